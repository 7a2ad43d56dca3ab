"""What each kind of command does, and when it is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.flight.executive.rig import HOLD, SECOND, A, B, C, Rig
from waypointctl.log.messages import CommandKind, EventKind, Mode, Stage

UPLOAD, APPEND, RELEASE, GO_TO = (
    CommandKind.UPLOAD_PLAN,
    CommandKind.APPEND_PLAN,
    CommandKind.RELEASE,
    CommandKind.GO_TO,
)
WHOLE_LIFE = [Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED, Stage.COMPLETED]


# Plans


@pytest.mark.parametrize("kind", [UPLOAD, GO_TO, CommandKind.RETURN_HOME])
def test_what_is_new_supersedes_what_is_under_way(walking: Rig, kind: CommandKind) -> None:
    walking.send(1.0, APPEND, C, id=2)
    waypoints = () if kind is CommandKind.RETURN_HOME else (B,)
    walking.send(2.0, kind, *waypoints, id=3)
    assert walking.ended(1) == walking.ended(2) == (Stage.SUPERSEDED, "by command 3")
    assert walking.sense(3.0, "b" if waypoints else "start") is Mode.DONE
    assert walking.stages_of(3) == WHOLE_LIFE


def test_an_appended_plan_starts_when_its_turn_comes(walking: Rig) -> None:
    assert walking.send(1.0, APPEND, C, id=2) is Stage.ACCEPTED
    walking.sense(2.0, "a")
    assert walking.executive.goals.tolist() == [[[5.0, 5.0], [0.0, 5.0]]], "the next leg is known on this one"
    walking.sense(3.0, "b")
    assert (walking.stage(1), walking.stage(2)) == (Stage.COMPLETED, Stage.STARTED)
    assert walking.executive.target == C
    assert walking.sense(4.0, "c") is Mode.DONE
    assert walking.stages_of(2) == WHOLE_LIFE
    assert walking.kinds.count(EventKind.PLAN_COMPLETED) == 1


def test_a_plan_that_is_done_goes_on_with_what_is_appended(rig: Rig) -> None:
    rig.command(0.0, A)
    assert rig.sense(1.0, "a") is Mode.DONE
    rig.send(5.0, APPEND, B, id=2)
    assert rig.executive.mode is Mode.NAVIGATING
    rig.sense(6.0, "b")
    assert rig.stages_of(2) == WHOLE_LIFE


@pytest.mark.parametrize("end", ["never begun", "failed", "cancelled", "home"])
def test_nothing_is_appended_to_a_plan_that_is_not(rig: Rig, end: str) -> None:
    if end != "never begun":
        rig.command(0.0, A)
    if end == "failed":
        rig.sense(10.0, "start")
    elif end == "cancelled":
        rig.send(1.0, CommandKind.CANCEL, id=2, target_id=1)
    elif end == "home":
        rig.send(1.0, CommandKind.RETURN_HOME, id=2)
    rig.send(11.0, APPEND, B, id=3)
    assert rig.ended(3) == (Stage.REJECTED, "there is no plan"), "b without a is not what was planned"


def test_a_plan_is_walked_as_far_as_it_is_released(rig: Rig) -> None:
    rig.send(0.0, UPLOAD, A, B, C, id=1, released=1)
    assert rig.executive.goals.tolist() == [[[5.0, 0.0], [5.0, 0.0]]], "it will have to stop there"
    assert rig.sense(1.0, "a") is Mode.WAITING
    assert rig.executive.target is None
    assert rig.kinds[-1] is EventKind.RELEASE_AWAITED
    assert rig.sense(500.0, "b") is Mode.WAITING, "it is not looking for b"
    assert rig.send(501.0, RELEASE, id=2, released=2) is Stage.COMPLETED
    assert rig.executive.mode is Mode.NAVIGATING
    assert rig.send(502.0, RELEASE, id=3, released=-1) is Stage.COMPLETED
    assert rig.executive.goals.tolist() == [[[5.0, 5.0], [0.0, 5.0]]], "now it need not stop at b"
    rig.sense(503.0, "b")
    assert rig.sense(504.0, "c") is Mode.DONE
    assert rig.executive.reached == (0, 1, 2)


def test_a_release_is_refused_or_comes_too_late(rig: Rig) -> None:
    rig.send(0.0, RELEASE, id=1)
    assert rig.ended(1) == (Stage.REJECTED, "there is no plan")
    rig.send(0.0, UPLOAD, A, B, id=2, released=1)
    rig.send(0.0, RELEASE, id=3, released=3)
    assert rig.ended(3) == (Stage.REJECTED, "there are 2 waypoints in the plan")
    rig.send(0.0, RELEASE, id=4, released=1)
    assert rig.ended(4) == (Stage.SKIPPED, "late: 1 of 2 waypoints are released already")
    assert rig.send(0.0, RELEASE, id=5, released=0) is Stage.SKIPPED


def test_nothing_released_is_nothing_walked(rig: Rig) -> None:
    assert rig.send(0.0, UPLOAD, A, id=1, released=0) is Stage.STARTED
    assert rig.executive.mode is Mode.WAITING


# Hold and resume


def test_clocks_stand_still_while_it_is_held(walking: Rig) -> None:
    walking.sense(4.0, "start")
    assert walking.send(4.0, CommandKind.HOLD, id=2) is Stage.COMPLETED
    assert walking.sense(1000.0, "a") is Mode.PAUSED, "it has no eyes for waypoints meanwhile"
    assert walking.executive.target == A
    assert walking.send(1000.0, CommandKind.RESUME, id=3) is Stage.COMPLETED
    assert walking.sense(1005.98, "start") is Mode.NAVIGATING
    assert walking.sense(1006.0, "start") is Mode.FAILED, "10 s in all, 4 of them before the hold"


def test_a_hold_at_a_waypoint_goes_on_after_a_pause(rig: Rig) -> None:
    rig.command(0.0, HOLD, B)
    rig.sense(1.0, "a")
    rig.send(2.0, CommandKind.HOLD, id=2)
    rig.send(60.0, CommandKind.RESUME, id=3)
    assert rig.sense(60.98, "a") is Mode.HOLDING
    assert rig.sense(61.0, "a") is Mode.NAVIGATING


def test_a_wait_for_a_release_goes_on_after_a_pause(rig: Rig) -> None:
    rig.send(0.0, UPLOAD, A, id=1, released=0)
    rig.send(1.0, CommandKind.HOLD, id=2)
    rig.send(2.0, RELEASE, id=3)
    assert rig.sense(2.5, "start") is Mode.PAUSED
    rig.send(3.0, CommandKind.RESUME, id=4)
    assert rig.executive.mode is Mode.NAVIGATING


def test_a_robot_that_stands_is_held_at_once(rig: Rig) -> None:
    assert rig.send(0.0, CommandKind.HOLD, id=1) is Stage.COMPLETED
    assert rig.executive.mode is Mode.IDLE
    assert rig.send(1.0, CommandKind.RESUME, id=2) is Stage.REJECTED


def test_a_pause_ends_with_the_plan_that_it_was_in(walking: Rig) -> None:
    walking.send(1.0, CommandKind.HOLD, id=2)
    walking.send(2.0, UPLOAD, C, id=3)
    assert walking.executive.mode is Mode.NAVIGATING
    assert walking.executive.target == C


# Skip


def test_a_skip_leaves_the_waypoint_under_way(walking: Rig) -> None:
    assert walking.send(1.0, CommandKind.SKIP, id=2) is Stage.COMPLETED
    assert walking.executive.target == B
    assert EventKind.WAYPOINT_SKIPPED in walking.kinds
    walking.send(2.0, CommandKind.SKIP, id=3)
    assert (walking.executive.mode, walking.stage(1)) == (Mode.DONE, Stage.COMPLETED)
    assert walking.executive.reached == ()
    walking.send(3.0, CommandKind.SKIP, id=4)
    assert walking.ended(4) == (Stage.REJECTED, "there is no waypoint to skip")


def test_a_skip_that_names_its_waypoint_cannot_hit_another(walking: Rig) -> None:
    walking.sense(1.0, "a")
    walking.send(2.0, CommandKind.SKIP, A, id=2)
    assert walking.ended(2) == (Stage.SKIPPED, "late: a is over")
    assert walking.executive.target == B
    walking.send(3.0, CommandKind.SKIP, C, id=3)
    assert walking.ended(3) == (Stage.REJECTED, "c is not in the plan")


def test_a_waypoint_to_come_can_be_skipped(walking: Rig) -> None:
    walking.send(1.0, CommandKind.SKIP, B, id=2)
    assert walking.executive.target == A
    assert walking.executive.goals.tolist() == [[[5.0, 0.0], [5.0, 0.0]]]
    assert walking.sense(2.0, "a") is Mode.DONE


def test_a_skip_in_a_pause_is_a_skip_and_still_a_pause(walking: Rig) -> None:
    walking.send(1.0, CommandKind.HOLD, id=2)
    walking.send(2.0, CommandKind.SKIP, id=3)
    assert walking.executive.mode is Mode.PAUSED
    walking.send(3.0, CommandKind.RESUME, id=4)
    assert walking.executive.target == B


# Cancel and abort


def test_a_cancelled_command_leaves_the_others_their_waypoints(walking: Rig) -> None:
    walking.send(1.0, APPEND, C, id=2)
    assert walking.send(2.0, CommandKind.CANCEL, id=3, target_id=1) is Stage.COMPLETED
    assert walking.ended(1) == (Stage.CANCELLED, "by command 3")
    assert (walking.executive.mode, walking.executive.target) == (Mode.NAVIGATING, C)
    walking.send(3.0, CommandKind.CANCEL, id=4, target_id=2)
    assert (walking.executive.mode, walking.executive.target) == (Mode.IDLE, None)


def test_cancelling_what_is_to_come_leaves_the_leg_alone(walking: Rig) -> None:
    walking.send(1.0, APPEND, C, id=2)
    walking.send(2.0, CommandKind.CANCEL, id=3, target_id=2)
    assert walking.executive.target == A
    assert walking.sense(9.98, "start") is Mode.NAVIGATING
    assert walking.sense(10.0, "start") is Mode.FAILED, "its clock ran on"


@pytest.mark.parametrize("target", [7, 2, -1])
def test_what_is_not_there_is_not_cancelled(walking: Rig, target: int) -> None:
    walking.send(1.0, CommandKind.CANCEL, id=2, target_id=target)
    assert walking.ended(2) == (Stage.REJECTED, "unknown command")


def test_what_is_over_is_not_cancelled(walking: Rig) -> None:
    walking.sense(1.0, "a")
    walking.sense(2.0, "b")
    walking.send(3.0, CommandKind.CANCEL, id=2, target_id=1)
    assert walking.ended(2) == (Stage.REJECTED, "already final: completed")
    assert walking.stage(1) is Stage.COMPLETED


def test_an_abort_ends_everything(walking: Rig) -> None:
    walking.send(1.0, APPEND, C, id=2)
    walking.send(1.0, CommandKind.RESUME, id=3, not_before=20.0)
    assert walking.send(2.0, CommandKind.ABORT, id=4) is Stage.COMPLETED
    assert {walking.ended(id) for id in (1, 2, 3)} == {(Stage.CANCELLED, "by command 4")}
    assert walking.executive.mode is Mode.IDLE
    assert walking.sense(30.0, "a") is Mode.IDLE


# Tolerance, time and home


def test_another_tolerance_is_for_this_waypoint_and_those_to_come(walking: Rig) -> None:
    assert walking.sense(1.0, (4.0, 0.0)) is Mode.NAVIGATING
    assert walking.send(1.0, CommandKind.SET_TOLERANCE, id=2, value=1.5) is Stage.COMPLETED
    walking.sense(2.0, (4.0, 0.0))
    assert walking.executive.reached == (0,)
    assert walking.executive.target == replace(B, tolerance_m=1.5)


def test_another_time_is_for_this_waypoint_and_those_to_come(walking: Rig) -> None:
    walking.send(1.0, CommandKind.SET_TIMEOUT, id=2, value=3.0)
    assert walking.executive.target == replace(A, timeout_ns=3 * SECOND)
    assert walking.sense(2.98, "start") is Mode.NAVIGATING
    assert walking.sense(3.0, "start") is Mode.FAILED


@pytest.mark.parametrize("kind", [CommandKind.SET_TOLERANCE, CommandKind.SET_TIMEOUT])
def test_what_has_no_waypoints_to_come_has_nothing_to_set(rig: Rig, kind: CommandKind) -> None:
    rig.send(1.0, kind, id=1, value=3.0)
    assert rig.ended(1) == (Stage.REJECTED, "there are no waypoints to come")


def test_it_returns_home_and_is_done_there(walking: Rig) -> None:
    assert walking.send(1.0, CommandKind.RETURN_HOME, id=2) is Stage.STARTED
    assert walking.executive.mode is Mode.RETURNING
    assert walking.executive.goals.tolist() == [[[0.0, 0.0], [0.0, 0.0]]]
    walking.send(2.0, CommandKind.HOLD, id=3)
    assert walking.sense(400.0, "start") is Mode.PAUSED
    walking.send(400.0, CommandKind.RESUME, id=4)
    assert walking.sense(401.0, (0.6, 0.0)) is Mode.RETURNING
    assert walking.sense(402.0, (0.4, 0.0)) is Mode.DONE
    assert walking.stages_of(2) == WHOLE_LIFE
    assert EventKind.HOME_REACHED in walking.kinds
    assert walking.executive.reached == (), "home is no waypoint"


def test_the_way_home_can_fail(walking: Rig) -> None:
    walking.send(1.0, CommandKind.RETURN_HOME, id=2)
    assert walking.sense(301.0, "a") is Mode.FAILED
    assert walking.ended(2) == (Stage.FAILED, "timeout")


def test_the_way_home_can_be_cancelled(walking: Rig) -> None:
    walking.send(1.0, CommandKind.RETURN_HOME, id=2)
    walking.send(2.0, CommandKind.CANCEL, id=3, target_id=2)
    assert (walking.executive.mode, walking.executive.target) == (Mode.IDLE, None)


@pytest.mark.parametrize(("released", "named"), [(-1, "all"), (0, "0"), (1, "1")])
def test_a_release_that_is_received_names_its_count(rig: Rig, released: int, named: str) -> None:
    rig.send(0.0, RELEASE, id=1, released=released)
    assert rig.events[0].text == f"command 1 received: release {named}"
