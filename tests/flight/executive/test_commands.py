"""What each kind of command does, and when it is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.flight.executive.rig import HOLD, SECOND, A, B, C, Rig
from waypointctl.flight.executive.fence import Circle, Fence
from waypointctl.log.messages import CommandKind, EventKind, Mode, Stage

UPLOAD, APPEND, RELEASE, GO_TO = (
    CommandKind.UPLOAD_PLAN,
    CommandKind.APPEND_PLAN,
    CommandKind.RELEASE,
    CommandKind.GO_TO,
)
ALL_BUT_PLANS = [kind for kind in CommandKind if kind not in (UPLOAD, APPEND, GO_TO)]
WHOLE_LIFE = [Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED, Stage.COMPLETED]


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def walking(rig: Rig) -> Rig:
    """Command 1 is under way to a, and b comes after it."""
    rig.command(0.0, A, B)
    return rig


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
    assert rig.send(0.0, RELEASE, id=1) is Stage.REJECTED
    rig.send(0.0, UPLOAD, A, B, id=2, released=1)
    rig.send(0.0, RELEASE, id=3, released=3)
    assert rig.ended(3) == (Stage.REJECTED, "there are 2 waypoints in the plan")
    rig.send(0.0, RELEASE, id=4, released=1)
    assert rig.ended(4) == (Stage.SKIPPED, "late: 1 of 2 waypoints are released already")


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


# Tasks


def test_an_observation_is_taken_after_the_hold(rig: Rig) -> None:
    rig.command(0.0, replace(HOLD, task="observe"), B)
    assert rig.sense(1.0, "a") is Mode.HOLDING
    assert rig.sense(3.0, "a") is Mode.OBSERVING
    assert rig.sense(3.98, "a") is Mode.OBSERVING
    assert rig.sense(4.0, (4.9, 0.1)) is Mode.NAVIGATING
    (taken,) = (event for event in rig.events if event.kind is EventKind.OBSERVATION_TAKEN)
    assert taken.text == "observation taken at a: x 4.90 m, y 0.10 m, heading 28.6 deg"
    assert (taken.time_ns, taken.waypoint, taken.command_id) == (4 * SECOND, 0, 1)


def test_a_waypoint_counts_as_reached_once_however_often_it_is_walked_to(rig: Rig) -> None:
    rig.command(0.0, A, B, A)
    rig.sense(1.0, "a")
    rig.sense(2.0, "b")
    assert rig.sense(3.0, "a") is Mode.DONE
    assert rig.executive.reached == (0, 1)


# Times


def test_a_command_waits_for_its_time(walking: Rig) -> None:
    assert walking.send(1.0, GO_TO, C, id=2, not_before=5.0) is Stage.ACCEPTED
    walking.sense(4.98, "start")
    assert walking.executive.target == A
    walking.sense(5.0, "start")
    assert walking.executive.target == C
    assert (walking.stage(1), walking.stage(2)) == (Stage.SUPERSEDED, Stage.STARTED)


def test_commands_that_wait_start_in_the_order_of_their_times(rig: Rig) -> None:
    rig.send(0.0, GO_TO, B, id=1, not_before=5.0)
    rig.send(1.0, GO_TO, A, id=2, not_before=4.0)
    rig.send(2.0, GO_TO, C, id=3, not_before=5.0)
    rig.sense(6.0, "start")
    assert rig.executive.target == C
    assert [rig.ended(id) for id in (1, 2)] == [(Stage.SUPERSEDED, "by command 3"), (Stage.SUPERSEDED, "by command 1")]


def test_a_command_that_waits_can_be_cancelled_or_fail_when_its_time_comes(walking: Rig) -> None:
    walking.send(1.0, CommandKind.RESUME, id=2, not_before=3.0)
    walking.send(1.0, CommandKind.SKIP, id=3, not_before=3.0)
    walking.send(2.0, CommandKind.CANCEL, id=4, target_id=3)
    walking.sense(3.0, "start")
    assert walking.ended(2) == (Stage.FAILED, "there is nothing to go on with")
    assert walking.ended(3) == (Stage.CANCELLED, "by command 4")
    assert walking.executive.target == A


def test_a_command_expires_before_it_starts(walking: Rig) -> None:
    walking.send(1.0, APPEND, C, id=2, expires=3.0)
    walking.sense(3.0, "start")
    assert walking.stage(2) is Stage.ACCEPTED
    walking.sense(3.02, "start")
    assert walking.ended(2) == (Stage.EXPIRED, "not started in time")
    assert walking.executive.target == A


def test_a_command_expires_under_way(rig: Rig) -> None:
    rig.send(1.0, GO_TO, A, id=1, expires=3.0)
    assert rig.sense(3.02, "start") is Mode.IDLE
    assert rig.ended(1) == (Stage.EXPIRED, "not completed in time")


def test_a_command_that_arrives_after_its_time_has_expired(rig: Rig) -> None:
    rig.send(4.0, GO_TO, A, id=1, expires=3.0)
    assert rig.stages_of(1) == [Stage.RECEIVED, Stage.EXPIRED]
    assert rig.ended(1) == (Stage.EXPIRED, "late")


def test_a_late_plan_starts_at_once_unless_all_of_it_is_reached(rig: Rig) -> None:
    rig.command(0.0, A)
    rig.sense(1.0, "a")
    rig.send(5.0, UPLOAD, A, id=2, not_before=3.0)
    assert rig.ended(2) == (Stage.SKIPPED, "late: a reached already")
    assert rig.send(5.0, UPLOAD, A, B, id=3, not_before=3.0) is Stage.STARTED
    assert rig.send(5.0, UPLOAD, A, id=4) is Stage.STARTED, "who asks for it again without a time gets it again"


# Arguments


@pytest.mark.parametrize("kind", ALL_BUT_PLANS)
def test_a_fallen_robot_obeys_nothing(rig: Rig, kind: CommandKind) -> None:
    rig.sense(0.0, "start", fell=True)
    rig.send(1.0, kind, id=1, value=1.0)
    assert rig.ended(1) == (Stage.REJECTED, "fall")


@pytest.mark.parametrize(
    ("kind", "waypoints", "arguments", "reason"),
    [
        (UPLOAD, (), {}, "upload_plan takes 1 to 10,000 waypoints, and has 0"),
        (GO_TO, (A, B), {}, "go_to takes 1 waypoint, and has 2"),
        (CommandKind.HOLD, (A,), {}, "hold takes 0 waypoints, and has 1"),
        (UPLOAD, (A,), {"released": 2}, "it releases 2 of 1 waypoints"),
        (UPLOAD, (A,), {"on_failure": "dance"}, "on_failure is 'dance'"),
        (UPLOAD, (A,), {"not_before": 9.0, "expires": 8.0}, "it expires before it may start"),
        (RELEASE, (), {"released": -2}, "it releases -2 waypoints"),
        (CommandKind.SET_TOLERANCE, (), {"value": 0.0}, "a tolerance of 0 m is out of bounds"),
        (CommandKind.SET_TOLERANCE, (), {"value": 100.1}, "a tolerance of 100.1 m is out of bounds"),
        (CommandKind.SET_TIMEOUT, (), {"value": 1e6}, "a time-out of 1e+06 s is out of bounds"),
        (CommandKind.SET_TIMEOUT, (), {"value": 0.0}, "a time-out of 0 s is out of bounds"),
        (CommandKind.SET_TIMEOUT, (), {"value": float("nan")}, "its value is nan"),
        (GO_TO, (replace(A, x_m=1e5),), {}, "a at (100000, 0) is out of bounds"),
        (GO_TO, (replace(A, acceptance="square"),), {}, "a: acceptance 'square' within 0.5 m is out of bounds"),
        (GO_TO, (replace(A, timeout_ns=0),), {}, "a: a time-out of 0 s is out of bounds"),
        (GO_TO, (replace(A, hold_ns=-1),), {}, "a: a hold of -1e-09 s is out of bounds"),
        (GO_TO, (replace(A, task="dig"),), {}, "a: the task 'dig' is unknown"),
        (GO_TO, (replace(A, x_m=30.0),), {}, "geofence: a at (30, 0) is outside keep-in"),
        (UPLOAD, (B, A), {}, "geofence: a at (5, 0) is inside keep-out pond"),
    ],
)
def test_wrong_arguments_are_refused(
    kind: CommandKind, waypoints: tuple[object, ...], arguments: dict[str, object], reason: str
) -> None:
    fence = Fence((Circle("yard", (0.0, 0.0), 20.0),), (Circle("pond", (5.0, 0.0), 0.1),))
    rig = Rig(fence=fence)
    rig.send(0.0, UPLOAD, B, id=1)
    rig.send(1.0, kind, *waypoints, id=2, **arguments)  # type: ignore[arg-type]
    assert rig.ended(2) == (Stage.REJECTED, reason)
    assert rig.stages_of(2) == [Stage.RECEIVED, Stage.REJECTED]
    assert (rig.executive.command_id, rig.executive.target) == (1, B), "and nothing has changed"


def test_a_plan_of_one_waypoint_has_one(rig: Rig) -> None:
    rig.send(0.0, UPLOAD, A, id=1)
    rig.send(0.0, RELEASE, id=2, released=3)
    assert rig.ended(2) == (Stage.REJECTED, "there is 1 waypoint in the plan")
