from __future__ import annotations

import json
from typing import Any

import pytest

from tests.flight.executive.rig import HOLD, SECOND, A, B, Rig
from waypointctl.flight.executive.rules import FALL, TIMEOUT
from waypointctl.log.messages import Clock, CommandKind, CommandStage, EventKind, Mode, Stage


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_stands_idle_until_it_is_commanded(rig: Rig) -> None:
    assert rig.sense(0.0, "start") is Mode.IDLE
    assert rig.sense(1000.0, "a") is Mode.IDLE
    assert rig.executive.target is None
    assert not rig.reports
    assert not rig.events


def test_a_command_is_received_accepted_and_started_at_once(rig: Rig) -> None:
    rig.command(3.0, A, B)
    assert rig.executive.mode is Mode.NAVIGATING
    assert rig.executive.target == A
    assert rig.executive.goals.tolist() == [[[5.0, 0.0], [5.0, 5.0]]]
    assert rig.reports == [(3 * SECOND, 1, stage, "") for stage in (Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED)]
    assert [(e.kind, e.time_ns, e.waypoint, e.command_id, e.clock) for e in rig.events] == [
        (EventKind.COMMAND_RECEIVED, 3 * SECOND, -1, 1, Clock.ROBOT),
        (EventKind.LEG_STARTED, 3 * SECOND, 0, 1, Clock.ROBOT),
    ]


def test_walks_from_waypoint_to_waypoint_and_is_done_at_the_last(rig: Rig) -> None:
    rig.command(0.0, A, B)
    assert rig.sense(1.0, (4.4, 0.0)) is Mode.NAVIGATING
    assert rig.sense(2.0, (4.6, 0.49)) is Mode.NAVIGATING
    assert (rig.executive.target, rig.executive.reached) == (B, (0,))
    assert rig.executive.goals.tolist() == [[[5.0, 5.0], [5.0, 5.0]]]
    assert rig.sense(3.0, (4.6, 4.6)) is Mode.NAVIGATING, "in the box, but the second waypoint has a radius"
    assert rig.sense(4.0, "b") is Mode.DONE
    assert (rig.executive.target, rig.executive.reached) == (None, (0, 1))
    assert rig.reports[-1] == (4 * SECOND, 1, Stage.COMPLETED, "")
    assert rig.kinds[1:] == [
        EventKind.LEG_STARTED,
        EventKind.WAYPOINT_REACHED,
        EventKind.LEG_STARTED,
        EventKind.WAYPOINT_REACHED,
        EventKind.PLAN_COMPLETED,
    ]
    assert rig.sense(5.0, "start") is Mode.DONE, "done is done"


def test_holds_at_a_waypoint_for_its_time_wherever_it_drifts(rig: Rig) -> None:
    rig.command(0.0, HOLD, B)
    assert rig.sense(1.0, "a") is Mode.HOLDING
    assert rig.executive.target == HOLD
    assert rig.sense(2.98, (7.0, 0.0)) is Mode.HOLDING
    assert rig.executive.reached == (0,)
    assert rig.sense(3.0, (7.0, 0.0)) is Mode.NAVIGATING
    assert rig.executive.target == B
    assert rig.kinds[2:] == [
        EventKind.WAYPOINT_REACHED,
        EventKind.HOLD_STARTED,
        EventKind.HOLD_COMPLETED,
        EventKind.LEG_STARTED,
    ]


def test_a_hold_at_the_last_waypoint_comes_before_the_end(rig: Rig) -> None:
    rig.command(0.0, HOLD)
    assert rig.sense(1.0, "a") is Mode.HOLDING
    assert Stage.COMPLETED not in rig.stages
    assert rig.sense(3.0, "a") is Mode.DONE
    assert rig.stages[-1] is Stage.COMPLETED


def test_the_next_legs_time_begins_when_the_hold_is_over(rig: Rig) -> None:
    rig.command(0.0, HOLD, B)
    rig.sense(9.0, "a")
    rig.sense(11.0, "a")
    assert rig.sense(30.98, "start") is Mode.NAVIGATING
    assert rig.sense(31.0, "start") is Mode.FAILED


def test_a_waypoint_that_is_not_reached_in_time_ends_the_plan(rig: Rig) -> None:
    rig.command(5.0, A, B)
    assert rig.sense(14.98, "start") is Mode.NAVIGATING
    assert rig.sense(15.0, "start") is Mode.FAILED
    assert rig.executive.target is None
    assert rig.reports[-1] == (15 * SECOND, 1, Stage.FAILED, TIMEOUT)
    assert rig.kinds[-2:] == [EventKind.WAYPOINT_TIMEOUT, EventKind.PLAN_FAILED]
    assert rig.sense(16.0, "a") is Mode.FAILED, "given up is given up"
    assert rig.executive.reached == ()


def test_reaching_a_waypoint_in_the_last_moment_counts(rig: Rig) -> None:
    rig.command(0.0, A, B)
    assert rig.sense(10.0, "a") is Mode.NAVIGATING
    assert rig.executive.reached == (0,)


def test_with_skip_the_next_leg_begins(rig: Rig) -> None:
    rig.command(0.0, A, B, on_failure="skip")
    assert rig.sense(10.0, "start") is Mode.NAVIGATING
    assert rig.executive.target == B
    assert rig.kinds[-3:] == [EventKind.WAYPOINT_TIMEOUT, EventKind.WAYPOINT_SKIPPED, EventKind.LEG_STARTED]
    assert rig.sense(12.0, "b") is Mode.DONE
    assert rig.executive.reached == (1,)
    assert rig.stages[-1] is Stage.COMPLETED


def test_skipping_the_last_waypoint_completes_the_plan(rig: Rig) -> None:
    rig.command(0.0, A, on_failure="skip")
    assert rig.sense(10.0, "start") is Mode.DONE
    assert rig.executive.reached == ()
    assert rig.stages[-1] is Stage.COMPLETED


@pytest.mark.parametrize("mode", [Mode.NAVIGATING, Mode.HOLDING])
def test_a_fall_on_the_way_fails_the_command(rig: Rig, mode: Mode) -> None:
    rig.command(0.0, HOLD, B)
    if mode is Mode.HOLDING:
        rig.sense(0.5, "a")
    assert rig.executive.mode is mode
    assert rig.sense(1.0, "start", fell=True) is Mode.FALLEN
    assert rig.reports[-1] == (SECOND, 1, Stage.FAILED, FALL)
    assert rig.kinds[-1] is EventKind.FALL
    said = len(rig.reports), len(rig.events)
    assert rig.sense(2.0, "a", fell=False) is Mode.FALLEN, "nothing gets it up again"
    assert (len(rig.reports), len(rig.events)) == said


@pytest.mark.parametrize("mode", [Mode.IDLE, Mode.DONE, Mode.FAILED])
def test_a_fall_while_standing_fails_no_command(rig: Rig, mode: Mode) -> None:
    if mode is not Mode.IDLE:
        rig.command(0.0, A)
        rig.sense(10.0, "a" if mode is Mode.DONE else "start")
    assert rig.executive.mode is mode
    said = len(rig.reports)
    assert rig.sense(11.0, "start", fell=True) is Mode.FALLEN
    assert rig.kinds[-1] is EventKind.FALL
    assert len(rig.reports) == said


def test_a_fallen_robot_rejects_commands(rig: Rig) -> None:
    rig.sense(0.0, "start", fell=True)
    rig.command(1.0, A)
    assert rig.executive.mode is Mode.FALLEN
    assert rig.reports == [(SECOND, 1, Stage.RECEIVED, ""), (SECOND, 1, Stage.REJECTED, FALL)]


@pytest.mark.parametrize("id", [1, 2])
def test_an_id_is_obeyed_once_and_a_new_one_replaces_the_plan(rig: Rig, id: int) -> None:
    rig.command(0.0, A)
    before = list(rig.reports), list(rig.events)
    rig.command(1.0, B, id=id)
    if id == 1:
        assert (rig.reports, rig.events) == before
        assert rig.executive.target == A
    else:
        assert rig.executive.target == B
        assert rig.executive.state()["command_id"] == 2
        assert rig.stages[3:] == [Stage.RECEIVED, Stage.ACCEPTED, Stage.SUPERSEDED, Stage.STARTED]
        assert rig.ended(1) == (Stage.SUPERSEDED, "by command 2")


@pytest.mark.parametrize("end", [Mode.DONE, Mode.FAILED, Mode.HOLDING])
def test_a_new_command_is_taken_from_every_mode_but_fallen(rig: Rig, end: Mode) -> None:
    rig.command(0.0, HOLD if end is Mode.HOLDING else A)
    rig.sense(10.0, "start" if end is Mode.FAILED else "a")
    assert rig.executive.mode is end
    rig.command(11.0, B, id=2)
    assert rig.executive.mode is Mode.NAVIGATING
    assert rig.sense(12.0, "b") is Mode.DONE
    assert rig.reports[-1] == (12 * SECOND, 2, Stage.COMPLETED, "")


def test_its_state_is_plain_data_and_says_all_of_it(rig: Rig) -> None:
    rig.command(1.0, HOLD, B, on_failure="skip")
    rig.sense(2.0, "a")
    state: dict[str, Any] = rig.executive.state()
    assert json.loads(json.dumps(state)) == state
    assert state["plan"]["items"][1] == {
        "waypoint": {
            "index": 1,
            "name": "b",
            "x_m": 5.0,
            "y_m": 5.0,
            "acceptance": "radius",
            "tolerance_m": 0.5,
            "timeout_ns": 20 * SECOND,
            "hold_ns": 0,
            "task": "",
        },
        "command_id": 1,
        "on_failure": "skip",
        "released": True,
        "over": False,
        "alone": False,
    }
    assert set(state.pop("plan")) == {"at", "items"}
    assert state == {
        "mode": "holding",
        "command_id": 1,
        "leg": {
            "since_ns": SECOND,
            "tries": 1,
            "best_m": None,
            "best_ns": SECOND,
            "goals": [[5.0, 0.0], [5.0, 5.0]],
        },
        "stood_ns": 2 * SECOND,
        "reached": [0],
        "suspended": None,
        "suspended_ns": 0,
        "cause": "",
        "home_id": None,
        "home_cause": "",
        "commands": {
            "records": {"1": {"stage": "started", "reason": "", "attempt": 1, "expires_ns": -1}},
            "pending": [],
        },
        "link": {"last_ns": SECOND, "lost": False},
        "fence": {"outside": False},
    }


def test_what_arrives_again_is_answered_with_the_stage_it_is_in(rig: Rig) -> None:
    rig.command(1.0, A)
    rig.command(2.0, A)
    rig.sense(3.0, "a")
    rig.command(4.0, A)
    assert rig.stages == [Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED, Stage.COMPLETED]
    assert rig.reminders == [
        CommandStage(2 * SECOND, 1, Stage.STARTED, "", Clock.ROBOT, 1),
        CommandStage(4 * SECOND, 1, Stage.COMPLETED, "", Clock.ROBOT, 1),
    ]


def test_a_plan_ends_with_the_flight(rig: Rig) -> None:
    rig.command(1.0, A, B)
    rig.executive.close(5 * SECOND)
    assert rig.reports[-1] == (5 * SECOND, 1, Stage.CANCELLED, "flight ended")


def test_whether_something_goes_on_by_itself() -> None:
    rig = Rig(link_loss_ns=60 * SECOND, on_link_loss="hold")
    assert not rig.executive.plans
    rig.send(0.0, CommandKind.HOLD, id=1)
    assert not rig.executive.plans
    rig.send(1.0, CommandKind.GO_TO, A, id=2, not_before=90.0)
    assert rig.executive.plans
    rig.sense(70.0, "start")
    assert not rig.executive.plans, "the link is lost, and what waits for its time waits for it"
    assert rig.executive.waits_for_ground
    rig.executive.on_contact(80 * SECOND)
    assert rig.executive.plans
    assert not rig.executive.waits_for_ground
    assert rig.executive.next_ns(80 * SECOND) == 90 * SECOND
    rig.sense(90.0, "start")
    assert (rig.executive.plans, rig.executive.next_ns(90 * SECOND)) == (True, 90 * SECOND)
    rig.sense(91.0, "a")
    assert not rig.executive.plans
    rig.send(92.0, CommandKind.APPEND_PLAN, B, id=3, released=0, expires=100.0)
    assert rig.executive.plans, "its expiry is still to come"
    assert rig.executive.next_ns(92 * SECOND) == 100 * SECOND
