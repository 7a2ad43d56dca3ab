"""When commands start and expire, what is done at a waypoint, and which arguments are refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.flight.executive.rig import HOLD, SECOND, A, B, C, Rig
from waypointctl.flight.executive.rules import Circle, Fence
from waypointctl.log.messages import CommandKind, EventKind, Mode, Stage

UPLOAD, APPEND, RELEASE, GO_TO = (
    CommandKind.UPLOAD_PLAN,
    CommandKind.APPEND_PLAN,
    CommandKind.RELEASE,
    CommandKind.GO_TO,
)
ALL_BUT_PLANS = [kind for kind in CommandKind if kind not in (UPLOAD, APPEND, GO_TO)]


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


def test_a_command_that_is_for_now_starts_now(walking: Rig) -> None:
    assert walking.send(5.0, GO_TO, C, id=2, not_before=5.0) is Stage.STARTED


def test_a_time_of_zero_is_a_time(rig: Rig) -> None:
    rig.command(0.0, A)
    rig.sense(1.0, "a")
    assert rig.send(2.0, UPLOAD, A, id=2, not_before=0.0) is Stage.SKIPPED, "too late, and reached already"
    assert rig.send(3.0, GO_TO, B, id=3, expires=0.0) is Stage.EXPIRED
    begun = Rig()
    assert begun.send(0.0, GO_TO, A, id=1, expires=0.0) is Stage.STARTED
    begun.sense(0.02, "start")
    assert begun.stage(1) is Stage.EXPIRED


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
        (CommandKind.SKIP, (A, B), {}, "skip takes 0 to 1 waypoint, and has 2"),
        (UPLOAD, (A,), {"released": 2}, "it releases 2 of 1 waypoints"),
        (UPLOAD, (A,), {"on_failure": "dance"}, "on_failure is 'dance'"),
        (UPLOAD, (A,), {"not_before": 9.0, "expires": 8.0}, "it expires before it may start"),
        (UPLOAD, (A,), {"released": -2}, "it releases -2 of 1 waypoints"),
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
    assert (rig.executive.state()["command_id"], rig.executive.target) == (1, B), "and nothing has changed"


def test_an_id_below_one_is_refused(rig: Rig) -> None:
    assert rig.send(0.0, CommandKind.HOLD, id=0) is Stage.REJECTED


def test_an_expiry_at_mission_start_is_one(rig: Rig) -> None:
    assert rig.send(0.0, UPLOAD, A, id=1, not_before=1.0, expires=0.0) is Stage.REJECTED


def test_a_waypoint_may_have_a_time_of_one_nanosecond(rig: Rig) -> None:
    assert rig.send(0.0, UPLOAD, replace(A, timeout_ns=1), id=1) is Stage.STARTED


def test_a_plan_of_one_waypoint_has_one(rig: Rig) -> None:
    rig.send(0.0, UPLOAD, A, id=1)
    rig.send(0.0, RELEASE, id=2, released=3)
    assert rig.ended(2) == (Stage.REJECTED, "there is 1 waypoint in the plan")
