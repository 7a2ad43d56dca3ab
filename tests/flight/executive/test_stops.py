"""What stops the robot and what it goes on with: holds, the ground's actions, the end; and what is reported of it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.flight.executive.rig import HOLD, SECOND, A, B, C, Rig
from waypointctl.flight.executive.rules import Circle, Fence
from waypointctl.flight.executive.state_machine import Signal, StateMachine
from waypointctl.log.messages import CommandKind, Event, EventKind, Mode, Severity, Stage

MINUTE = 60 * SECOND


def last(rig: Rig, kind: EventKind) -> Event:
    return [event for event in rig.events if event.kind is kind][-1]


# Nothing


def test_a_robot_that_has_done_nothing_has_no_goal_and_no_command(rig: Rig) -> None:
    assert rig.executive.goals.tolist() == [[[0.0, 0.0], [0.0, 0.0]]]
    state = rig.executive.state()
    assert (state["command_id"], state["stood_ns"], state["home_id"]) == (-1, 0, None)


# Holds


def test_a_hold_takes_over_what_a_rule_has_stopped(rig: Rig) -> None:
    rig.command(0.0, A, B, on_failure="hold")
    assert rig.sense(10.0, "start") is Mode.SAFE
    assert last(rig, EventKind.SAFE_HOLD_STARTED).severity is Severity.WARNING
    rig.send(11.0, CommandKind.HOLD, id=2)
    assert (rig.executive.mode, rig.executive.cause) == (Mode.PAUSED, "by command 2")
    assert last(rig, EventKind.NAVIGATION_PAUSED).severity is Severity.INFO
    rig.send(12.0, CommandKind.RESUME, id=3)
    assert (rig.executive.mode, rig.executive.cause) == (Mode.NAVIGATING, "")
    assert last(rig, EventKind.NAVIGATION_RESUMED).time_ns == 12 * SECOND


def test_a_robot_that_a_rule_has_sent_home_has_nothing_to_hold() -> None:
    rig = Rig(then="return_home")
    rig.command(0.0, A, on_failure="")
    rig.sense(10.0, (3.0, 0.0))
    assert rig.sense(11.0, "start") is Mode.SAFE
    assert rig.send(12.0, CommandKind.HOLD, id=2) is Stage.COMPLETED
    assert rig.executive.mode is Mode.SAFE


def test_a_hold_ends_teleoperation_and_leaves_a_robot_that_is_done(rig: Rig) -> None:
    rig.command(0.0, A)
    rig.sense(1.0, "a")
    rig.send(2.0, CommandKind.HOLD, id=2)
    assert rig.sense(2.5, "a") is Mode.DONE
    rig.executive.on_action(3 * SECOND)
    assert rig.sense(3.5, "a") is Mode.TELEOPERATED
    assert last(rig, EventKind.TELEOPERATION_STARTED).time_ns == 3 * SECOND
    rig.send(4.0, CommandKind.HOLD, id=3)
    assert rig.executive.mode is Mode.IDLE


def test_a_way_home_keeps_its_cause_over_a_hold() -> None:
    rig = Rig(then="return_home")
    rig.command(0.0, A, on_failure="")
    rig.sense(10.0, (3.0, 0.0))
    started = last(rig, EventKind.RETURN_STARTED)
    assert (started.time_ns, started.text) == (10 * SECOND, "returning home: timeout")
    state = rig.executive.state()
    assert (state["command_id"], state["home_id"]) == (-1, -1), "no command sent it"
    rig.send(11.0, CommandKind.HOLD, id=2)
    rig.send(12.0, CommandKind.RESUME, id=3)
    assert (rig.executive.mode, rig.executive.cause) == (Mode.RETURNING, "timeout")


def test_the_cause_of_a_failure_is_that_of_the_way_home_alone(rig: Rig) -> None:
    rig.command(0.0, A)
    assert rig.sense(10.0, "start") is Mode.FAILED
    assert rig.executive.cause == ""
    rig.send(11.0, CommandKind.RETURN_HOME, id=2)
    assert last(rig, EventKind.RETURN_STARTED).text == "returning home"
    assert rig.sense(311.0, "a") is Mode.FAILED
    assert rig.executive.cause == "way home given up: timeout"


def test_the_ground_that_is_gone_leaves_a_robot_that_stands(rig: Rig) -> None:
    rig.executive.on_action(0)
    rig.executive.release()
    assert rig.executive.mode is Mode.IDLE


def test_an_observation_is_reported_when_it_begins(rig: Rig) -> None:
    rig.command(0.0, replace(A, task="observe"))
    assert rig.sense(1.0, "a") is Mode.OBSERVING
    begun = last(rig, EventKind.OBSERVATION_STARTED)
    assert (begun.time_ns, begun.waypoint) == (SECOND, 0)


# The end


def test_a_fall_ends_what_waits_for_its_time_and_is_reported_once(rig: Rig) -> None:
    rig.send(0.0, CommandKind.GO_TO, A, id=1, not_before=9.0)
    rig.sense(1.0, "start", fell=True)
    assert rig.ended(1) == (Stage.CANCELLED, "fall")
    said = len(rig.events)
    assert rig.sense(2.0, "start", fell=True) is Mode.FALLEN
    assert len(rig.events) == said


def test_a_mode_changes_only_as_the_table_says() -> None:
    machine = StateMachine()
    with pytest.raises(RuntimeError, match="resume_leg"):
        machine.signal(Signal.RESUME_LEG)
    assert machine.mode is Mode.IDLE


# Times


def test_it_says_when_a_stop_ends_by_itself(rig: Rig) -> None:
    rig.command(0.0, replace(HOLD, task="observe"), B)
    assert rig.sense(1.0, "a") is Mode.HOLDING
    assert rig.executive.next_ns(2 * SECOND) == 3 * SECOND
    assert rig.sense(3.0, "a") is Mode.OBSERVING
    assert rig.executive.next_ns(3 * SECOND) == 4 * SECOND
    rig.send(3.5, CommandKind.HOLD, id=2)
    assert rig.executive.next_ns(4 * SECOND) is None


def test_it_says_until_when_a_message_keeps_it_from_giving_up() -> None:
    rig = Rig(link_loss_ns=MINUTE, on_link_loss="return_home")
    rig.executive.on_contact(0)
    assert rig.executive.gives_up_ns is None, "nothing is under way"
    rig.command(1.0, replace(A, timeout_ns=10 * MINUTE))
    assert rig.executive.gives_up_ns == SECOND + MINUTE
    rig.send(2.0, CommandKind.RETURN_HOME, id=2)
    assert rig.executive.gives_up_ns is None, "it returns home already"
    holding = Rig(link_loss_ns=MINUTE, on_link_loss="hold")
    holding.command(1.0, A)
    assert holding.executive.gives_up_ns is None


# Link and fence


@pytest.mark.parametrize(
    ("rule", "state", "named", "after"),
    [
        ("finish", "under way", True, Mode.NAVIGATING),
        ("finish", "waiting", False, Mode.WAITING),
        ("finish", "idle", False, Mode.IDLE),
        ("hold", "under way", True, Mode.SAFE),
        ("hold", "waiting", True, Mode.SAFE),
        ("hold", "idle", False, Mode.IDLE),
        ("return_home", "under way", True, Mode.RETURNING),
        ("return_home", "waiting", True, Mode.RETURNING),
        ("return_home", "idle", True, Mode.RETURNING),
        ("return_home", "returning", False, Mode.RETURNING),
    ],
)
def test_a_link_loss_names_its_rule_where_the_rule_acts(rule: str, state: str, named: bool, after: Mode) -> None:
    rig = Rig(link_loss_ns=MINUTE, on_link_loss=rule)
    if state == "idle":
        rig.executive.on_contact(0)
    elif state == "returning":
        rig.send(0.0, CommandKind.RETURN_HOME, id=1)
    else:
        released = 0 if state == "waiting" else -1
        rig.send(0.0, CommandKind.UPLOAD_PLAN, replace(A, timeout_ns=10 * MINUTE), id=1, released=released)
    assert rig.sense(61.0, (3.0, 0.0)) is after
    assert last(rig, EventKind.LINK_LOST).text.endswith(f": {rule}") is named


@pytest.mark.parametrize("state", ["idle", "holding"])
def test_a_robot_that_stands_is_not_stopped_by_its_fence(state: str) -> None:
    rig = Rig(fence=Fence((Circle("yard", (0.0, 0.0), 20.0),)))
    if state == "holding":
        rig.command(0.0, HOLD)
        rig.sense(1.0, "a")
    mode = rig.executive.mode
    assert rig.sense(2.0, (30.0, 0.0)) is mode
    assert EventKind.GEOFENCE_BREACHED not in rig.kinds


def test_what_is_appended_is_the_next_goal_of_the_leg_under_way(rig: Rig) -> None:
    rig.command(0.0, B)
    rig.send(1.0, CommandKind.APPEND_PLAN, C, id=2)
    assert rig.executive.goals.tolist() == [[[5.0, 5.0], [0.0, 5.0]]]
