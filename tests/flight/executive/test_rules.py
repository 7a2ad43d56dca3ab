"""What the robot does by itself: when a leg fails, the link is lost, or it walks out of its fence."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.flight.executive.rig import SECOND, A, B, C, Rig
from waypointctl.flight.executive.rules import Circle, Fence, Polygon, Rules, home_at, rules_of
from waypointctl.log.messages import TELEOPERATION, CommandKind, Event, EventKind, Mode, Severity, Stage
from waypointctl.mission.mission import Mission

YARD = Fence((Circle("yard", (0.0, 0.0), 20.0),), (Circle("pit", (3.0, 0.0), 1.0),))
MINUTE = 60 * SECOND


def event_of(rig: Rig, kind: EventKind) -> Event:
    (event,) = (event for event in rig.events if event.kind is kind)
    return event


# A leg that fails


def test_a_leg_is_begun_again_as_often_as_the_rule_says() -> None:
    rig = Rig(retries=2)
    rig.command(0.0, A)
    assert rig.sense(10.0, "start") is Mode.NAVIGATING
    assert rig.sense(20.0, "start") is Mode.NAVIGATING
    assert rig.sense(29.98, "start") is Mode.NAVIGATING
    assert rig.sense(30.0, "start") is Mode.FAILED
    retried = [event.text for event in rig.events if event.kind is EventKind.LEG_RETRIED]
    assert retried == ["a not reached within 10 s: attempt 2 of 3", "a not reached within 10 s: attempt 3 of 3"]
    assert rig.kinds.count(EventKind.WAYPOINT_TIMEOUT) == 1


def test_a_leg_that_succeeds_at_the_second_try_is_a_leg_that_succeeds() -> None:
    rig = Rig(retries=1)
    rig.command(0.0, A)
    rig.sense(10.0, "start")
    assert rig.sense(12.0, "a") is Mode.DONE
    assert rig.stages[-1] is Stage.COMPLETED


def test_each_leg_has_its_own_tries() -> None:
    rig = Rig(retries=1)
    rig.command(0.0, A, B)
    rig.sense(10.0, "start")
    rig.sense(12.0, "a")
    assert rig.sense(32.0, "a") is Mode.NAVIGATING
    assert rig.sense(52.0, "a") is Mode.FAILED


@pytest.mark.parametrize(("rule", "asked"), [("hold", ""), ("abort", "hold")])
def test_it_stands_and_waits_for_the_ground(rule: str, asked: str) -> None:
    rig = Rig(then=rule)
    rig.command(0.0, A, B, on_failure=asked)
    assert rig.sense(10.0, "start") is Mode.SAFE
    assert rig.stage(1) is Stage.STARTED, "nothing is decided yet"
    assert rig.sense(100.0, "a") is Mode.SAFE
    rig.send(101.0, CommandKind.RESUME, id=2)
    assert rig.sense(110.98, "start") is Mode.NAVIGATING, "with the whole of its time"
    assert rig.sense(111.0, "start") is Mode.SAFE
    rig.send(112.0, CommandKind.SKIP, id=3)
    rig.send(113.0, CommandKind.RESUME, id=4)
    assert (rig.executive.mode, rig.executive.target) == (Mode.NAVIGATING, B)


def test_it_goes_home_when_a_leg_has_failed() -> None:
    rig = Rig(then="return_home", home=home_at(-1.0, -1.0))
    rig.command(0.0, A, B, on_failure="")
    rig.send(1.0, CommandKind.APPEND_PLAN, C, id=2)
    assert rig.sense(10.0, "start") is Mode.RETURNING
    assert rig.ended(1) == (Stage.FAILED, "timeout")
    assert rig.ended(2) == (Stage.CANCELLED, "plan given up: timeout")
    assert rig.executive.goals.tolist() == [[[-1.0, -1.0], [-1.0, -1.0]]]
    assert rig.sense(11.0, (-1.0, -0.6)) is Mode.SAFE
    assert rig.send(12.0, CommandKind.RESUME, id=3) is Stage.REJECTED
    assert rig.send(13.0, CommandKind.GO_TO, A, id=4) is Stage.STARTED


def test_a_command_that_says_what_follows_a_failure_is_heeded() -> None:
    rig = Rig(then="abort")
    rig.command(0.0, A, B, on_failure="skip")
    assert rig.sense(10.0, "start") is Mode.NAVIGATING
    assert rig.executive.target == B


# Getting no closer


def test_a_robot_that_gets_no_closer_is_stuck() -> None:
    rig = Rig(stuck_fails=True, progress_m=0.1, stall_ns=5 * SECOND)
    rig.command(0.0, replace(A, timeout_ns=MINUTE))
    assert rig.sense(1.0, (2.0, 0.0)) is Mode.NAVIGATING
    assert rig.sense(5.0, (2.05, 0.0)) is Mode.NAVIGATING, "5 cm are no progress"
    assert rig.sense(5.98, (2.08, 0.0)) is Mode.NAVIGATING
    assert rig.sense(6.0, (2.08, 0.0)) is Mode.FAILED
    assert rig.ended(1) == (Stage.FAILED, "stuck")
    assert event_of(rig, EventKind.WAYPOINT_STUCK).text == "a not reached: no progress for 5 s"


def test_a_robot_that_gets_closer_is_not_stuck() -> None:
    rig = Rig(stuck_fails=True, progress_m=0.1, stall_ns=5 * SECOND)
    rig.command(0.0, replace(A, timeout_ns=MINUTE))
    for step in range(10):
        assert rig.sense(1.0 + 4 * step, (0.11 * step, 0.0)) is Mode.NAVIGATING
    rig.send(40.0, CommandKind.HOLD, id=2)
    rig.send(999.0, CommandKind.RESUME, id=3)
    assert rig.sense(1000.0, (0.99, 0.0)) is Mode.NAVIGATING, "a pause is no standstill"


def test_a_near_miss_is_accepted_once_it_gets_no_closer() -> None:
    rig = Rig(slip_m=1.0, stall_ns=5 * SECOND)
    rig.command(0.0, replace(A, timeout_ns=MINUTE), B)
    assert rig.sense(1.0, (4.2, 0.0)) is Mode.NAVIGATING
    assert rig.sense(5.98, (4.2, 0.0)) is Mode.NAVIGATING
    rig.sense(6.0, (4.2, 0.0))
    assert rig.executive.reached == (0,)
    assert event_of(rig, EventKind.WAYPOINT_REACHED).text == (
        "a reached within the stopped tolerance: 0.80 m away, no progress for 5 s"
    )


def test_a_miss_outside_the_slip_waits_for_its_time() -> None:
    rig = Rig(slip_m=1.0, stall_ns=5 * SECOND)
    rig.command(0.0, replace(A, timeout_ns=MINUTE))
    assert rig.sense(1.0, (3.9, 0.0)) is Mode.NAVIGATING
    assert rig.sense(30.0, (3.9, 0.0)) is Mode.NAVIGATING
    assert rig.sense(31.0, (4.1, 0.0)) is Mode.NAVIGATING, "this is closer"
    assert rig.sense(36.0, (4.1, 0.0)) is Mode.DONE


# The link


def lossy(do: str) -> Rig:
    rig = Rig(link_loss_ns=MINUTE, on_link_loss=do)
    assert rig.sense(500.0, "start") is Mode.IDLE, "what was never there is not lost"
    rig.command(1000.0, replace(A, timeout_ns=10 * MINUTE), replace(B, timeout_ns=10 * MINUTE))
    assert rig.sense(1060.0, "start") is Mode.NAVIGATING
    assert EventKind.LINK_LOST not in rig.kinds
    return rig


def test_it_finishes_what_it_was_told_without_a_link() -> None:
    rig = lossy("finish")
    assert rig.sense(1060.02, "start") is Mode.NAVIGATING
    assert event_of(rig, EventKind.LINK_LOST).severity is Severity.WARNING
    rig.sense(1100.0, "a")
    assert rig.sense(1200.0, "b") is Mode.DONE


def test_it_stands_until_the_ground_is_heard_again() -> None:
    rig = lossy("hold")
    assert rig.sense(1060.02, "start") is Mode.SAFE
    assert rig.sense(9000.0, "a") is Mode.SAFE
    rig.executive.on_contact(9001 * SECOND)
    assert event_of(rig, EventKind.LINK_RESTORED).time_ns == 9001 * SECOND
    assert (rig.executive.mode, rig.executive.target) == (Mode.NAVIGATING, replace(A, timeout_ns=10 * MINUTE))
    assert rig.sense(9061.02, "start") is Mode.SAFE, "and lost again"


def test_a_command_is_obeyed_after_the_outage_that_it_ends() -> None:
    rig = lossy("hold")
    rig.sense(1060.02, "start")
    assert rig.send(2000.0, CommandKind.HOLD, id=2) is Stage.COMPLETED
    assert rig.executive.mode is Mode.PAUSED


@pytest.mark.parametrize("back", ["on the way", "at home"])
def test_it_goes_home_without_a_link_and_stays_there(back: str) -> None:
    rig = lossy("return_home")
    assert rig.sense(1060.02, "a") is Mode.RETURNING
    assert rig.ended(1) == (Stage.FAILED, "link lost")
    if back == "on the way":
        rig.executive.on_contact(1061 * SECOND)
        assert rig.sense(1062.0, "a") is Mode.RETURNING
        assert rig.sense(1070.0, "start") is Mode.SAFE
    else:
        assert rig.sense(1070.0, "start") is Mode.SAFE
        rig.executive.on_contact(1080 * SECOND)
        assert rig.executive.mode is Mode.IDLE


@pytest.mark.parametrize(("target", "mode"), [(TELEOPERATION, Mode.RETURNING), (-1, Mode.PAUSED)])
def test_a_hold_of_teleoperation_leaves_the_way_home_alone_and_any_other_hold_stops_it(target: int, mode: Mode) -> None:
    rig = Rig(link_loss_ns=MINUTE, on_link_loss="return_home")
    rig.executive.on_action(0)
    assert rig.sense(60.02, "a") is Mode.RETURNING
    assert rig.send(61.0, CommandKind.HOLD, id=2, target_id=target) is Stage.COMPLETED
    assert rig.executive.mode is mode
    assert rig.send(62.0, CommandKind.RETURN_HOME, id=1) is Stage.STARTED, "older, and sent again"
    assert rig.executive.mode is mode


def test_a_hold_of_teleoperation_ends_it() -> None:
    rig = Rig()
    rig.executive.on_action(0)
    rig.send(1.0, CommandKind.HOLD, id=1, target_id=TELEOPERATION)
    assert rig.executive.mode is Mode.IDLE


def test_what_waits_for_its_time_waits_for_the_link_too() -> None:
    rig = lossy("hold")
    rig.send(1010.0, CommandKind.GO_TO, C, id=2, not_before=1080.0)
    rig.sense(1075.0, "start")
    assert rig.sense(1090.0, "start") is Mode.SAFE
    rig.executive.on_contact(1100 * SECOND)
    rig.sense(1100.0, "start")
    assert rig.executive.target == C


def test_a_pause_needs_no_link() -> None:
    rig = lossy("hold")
    rig.send(1060.0, CommandKind.HOLD, id=2)
    assert rig.sense(2000.0, "start") is Mode.PAUSED
    rig.executive.on_contact(2001 * SECOND)
    assert rig.executive.mode is Mode.PAUSED


@pytest.mark.parametrize("on_link_loss", ["finish", "hold", "return_home"])
def test_a_link_that_comes_back_does_not_move_a_robot_that_stands_for_another_reason(on_link_loss: str) -> None:
    rig = Rig(then="hold", link_loss_ns=MINUTE, on_link_loss=on_link_loss)
    rig.command(0.0, A, B, on_failure="hold")
    assert rig.sense(10.0, "start") is Mode.SAFE
    cause = rig.executive.cause
    rig.executive.on_contact(11 * SECOND)
    assert (rig.executive.mode, rig.executive.cause) == (Mode.SAFE, cause)
    if on_link_loss != "return_home":
        rig.sense(100.0, "start")
        assert EventKind.LINK_LOST in rig.kinds
        assert not rig.executive.waits_for_ground
        rig.executive.on_contact(101 * SECOND)
        assert EventKind.LINK_RESTORED in rig.kinds
        assert (rig.executive.mode, rig.executive.cause) == (Mode.SAFE, cause)


def test_a_robot_that_is_steered_stands_when_no_action_comes() -> None:
    rig = Rig(link_loss_ns=SECOND, on_link_loss="hold")
    rig.executive.on_action(0)
    assert rig.sense(1.02, "start") is Mode.SAFE
    rig.executive.on_action(2 * SECOND)
    assert rig.executive.mode is Mode.TELEOPERATED


def test_nothing_is_added_to_a_plan_that_the_ground_steered_away_from() -> None:
    rig = Rig()
    rig.command(0.0, A)
    rig.sense(1.0, "a")
    rig.executive.on_action(2 * SECOND)
    rig.send(3.0, CommandKind.APPEND_PLAN, B, id=2)
    assert rig.ended(2) == (Stage.REJECTED, "there is no plan")
    assert rig.executive.mode is Mode.TELEOPERATED


# The fence


@pytest.mark.parametrize(
    ("do", "after", "ended"),
    [
        ("hold", Mode.SAFE, (Stage.STARTED, "")),
        ("return_home", Mode.RETURNING, (Stage.FAILED, "geofence")),
        ("abort", Mode.FAILED, (Stage.FAILED, "geofence")),
    ],
)
def test_a_robot_that_walks_out_of_its_fence(do: str, after: Mode, ended: tuple[Stage, str]) -> None:
    rig = Rig(fence=YARD, on_breach=do)
    rig.command(0.0, A)
    assert rig.sense(1.0, (1.9, 0.0)) is Mode.NAVIGATING
    assert rig.sense(2.0, (2.1, 0.0)) is after
    assert rig.ended(1) == ended
    breach = event_of(rig, EventKind.GEOFENCE_BREACHED)
    assert breach.text == "the robot at (2.10, 0.00) is inside keep-out pit"
    assert breach.severity is Severity.ERROR


def test_a_robot_outside_is_stopped_again_only_after_having_been_in() -> None:
    rig = Rig(fence=YARD, on_breach="hold")
    rig.command(0.0, A)
    rig.sense(1.0, (2.1, 0.0))
    rig.send(2.0, CommandKind.RESUME, id=2)
    assert rig.sense(3.0, (3.0, 0.0)) is Mode.NAVIGATING
    assert rig.sense(4.0, (4.1, 0.0)) is Mode.NAVIGATING
    assert rig.sense(5.0, (3.9, 0.0)) is Mode.SAFE


def test_a_way_home_that_leads_through_the_fence_is_gone_on_with() -> None:
    rig = Rig(fence=YARD, on_breach="return_home")
    rig.command(0.0, A)
    rig.sense(1.0, (2.1, 0.0))
    rig.sense(2.0, (1.9, 0.0))
    assert rig.sense(3.0, (2.1, 0.0)) is Mode.RETURNING
    assert rig.sense(4.0, "start") is Mode.SAFE


@pytest.mark.parametrize("do", ["hold", "abort"])
def test_what_is_steered_out_of_the_fence_waits_for_a_command(do: str) -> None:
    rig = Rig(fence=YARD, on_breach=do)
    rig.executive.on_action(0)
    assert rig.sense(1.0, (3.0, 0.0)) is Mode.SAFE
    rig.executive.on_action(2 * SECOND)
    assert rig.sense(2.5, "start") is Mode.SAFE
    rig.send(3.0, CommandKind.ABORT, id=1)
    rig.executive.on_action(4 * SECOND)
    assert rig.executive.mode is Mode.TELEOPERATED


# From the mission file


def test_a_missions_rules_are_the_robots() -> None:
    mission = Mission.model_validate(
        {
            "name": "n",
            "policy": "p",
            "waypoints": [[1, 2]],
            "start": {"position_m": [1.0, -1.0]},
            "onboard": {
                "on_failure": {"retry": 2, "then": "hold"},
                "stopped_tolerance_m": 1.5,
                "stuck": {"within_m": 0.2, "for_s": 7.0},
                "link_loss": {"after_s": 60.0, "do": "return_home"},
                "geofence": {
                    "keep_in": [{"corners": [[0, 0], [9, 0], [9, 9]]}],
                    "keep_in_match": "all",
                    "keep_out": [{"name": "pit", "center_m": [3, 3], "radius_m": 1}],
                    "do": "abort",
                },
                "home": {"tolerance_m": 1.0, "timeout_s": 90.0},
            },
        }
    )
    assert rules_of(mission) == Rules(
        home=replace(home_at(1.0, -1.0), tolerance_m=1.0, timeout_ns=90 * SECOND),
        retries=2,
        then="hold",
        slip_m=1.5,
        progress_m=0.2,
        stall_ns=7 * SECOND,
        stuck_fails=True,
        link_loss_ns=MINUTE,
        on_link_loss="return_home",
        fence=Fence(
            (Polygon("1", ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0))),),
            (Circle("pit", (3.0, 3.0), 1.0),),
            keep_in_all=True,
        ),
        on_breach="abort",
    )


def test_a_mission_without_rules_is_flown_as_ever() -> None:
    mission = Mission.model_validate({"name": "n", "policy": "p", "waypoints": [[1, 2]], "on_failure": "skip"})
    assert rules_of(mission) == Rules(then="skip")
