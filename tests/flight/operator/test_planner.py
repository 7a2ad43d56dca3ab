from __future__ import annotations

import pytest

from tests.flight.operator.missions import ack, mission_of
from waypointctl.flight.operator.operator import ended_by_robot
from waypointctl.flight.operator.planner import MissionOperator, WaypointOperator
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.log.messages import CommandKind, Event, EventKind, Stage
from waypointctl.units import NS_PER_S


def test_a_waypoint_at_a_time_with_a_thought_between() -> None:
    operator = WaypointOperator(mission_of("operator: {think: 3 s}"))
    (first,) = operator.begin()
    operator.on_issued(1, first)
    assert [waypoint.name for waypoint in first.waypoints] == ["WP1"]
    assert operator.on_message(NS_PER_S, ack(Stage.COMPLETED)) == []
    assert operator.wake_ns == 4 * NS_PER_S
    (second,) = operator.wake(4 * NS_PER_S)
    operator.on_issued(2, second)
    assert [waypoint.name for waypoint in second.waypoints] == ["WP2"]
    assert operator.on_message(9 * NS_PER_S, ack(Stage.COMPLETED)) == [], "of an earlier command, once more"
    assert not operator.finished
    operator.on_message(10 * NS_PER_S, ack(Stage.COMPLETED, 2))
    assert (operator.finished, operator.failure) == (True, "")


@pytest.mark.parametrize("reason", ["timeout", "stuck"])
def test_a_leg_that_failed_is_skipped_or_ends_the_mission(reason: str) -> None:
    for then, finished in (("skip", False), ("abort", True)):
        operator = WaypointOperator(mission_of(f"on_failure: {then}"))
        operator.on_issued(1, operator.begin()[0])
        requests = operator.on_message(0, ack(Stage.FAILED, reason=reason))
        assert operator.finished is finished
        assert [request.waypoints[0].name for request in requests] == ([] if finished else ["WP2"])


@pytest.mark.parametrize(
    ("then", "on_board"), [("abort", "abort"), ("skip", "abort"), ("hold", ""), ("return_home", "")]
)
def test_what_the_board_is_to_do_with_a_single_waypoint(then: str, on_board: str) -> None:
    (request,) = WaypointOperator(mission_of(f"on_failure: {then}")).begin()
    assert request.on_failure == on_board


def test_what_another_command_did_to_the_plan_is_said() -> None:
    operator = MissionOperator(mission_of(""))
    (plan,) = operator.begin()
    assert plan.kind is CommandKind.UPLOAD_PLAN
    operator.on_issued(1, plan)
    operator.on_message(0, ack(Stage.SUPERSEDED, reason="by command 2"))
    assert (operator.finished, operator.failure) == (True, "superseded by command 2")


@pytest.mark.parametrize(
    ("stage", "own", "other", "failure"),
    [
        (Stage.SUPERSEDED, CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, "command 2 (go_to) replaced the plan"),
        (Stage.SUPERSEDED, CommandKind.GO_TO, CommandKind.GO_TO, "command 2 (go_to) replaced command 1"),
        (Stage.CANCELLED, CommandKind.UPLOAD_PLAN, CommandKind.ABORT, "cancelled by command 2 (abort)"),
    ],
)
def test_the_command_that_ended_another_is_named_with_its_kind(
    stage: Stage, own: CommandKind, other: CommandKind, failure: str
) -> None:
    said = ack(stage, reason="by command 2")
    assert ended_by_robot(said, {1: own, 2: other}) == failure


@pytest.mark.parametrize(
    ("stage", "reason", "failure"),
    [
        (Stage.COMPLETED, "", ""),
        (Stage.FAILED, "", "failed"),
        (Stage.REJECTED, "", "rejected"),
        (Stage.REJECTED, "geofence", "geofence"),
    ],
)
def test_an_end_without_a_reason_is_named_by_its_stage(stage: Stage, reason: str, failure: str) -> None:
    assert ended_by_robot(ack(stage, reason=reason), {}) == failure


@pytest.mark.parametrize(("stage", "reason"), [(Stage.FAILED, "geofence"), (Stage.CANCELLED, "timeout")])
def test_only_a_waypoint_that_was_not_reached_is_skipped(stage: Stage, reason: str) -> None:
    operator = WaypointOperator(mission_of("on_failure: skip"))
    operator.on_issued(1, operator.begin()[0])
    assert operator.on_message(0, ack(stage, reason=reason)) == []
    assert operator.finished


def test_a_waypoint_that_is_skipped_is_announced() -> None:
    events: list[Event] = []
    operator = WaypointOperator(mission_of("on_failure: skip"), events.append)
    operator.on_issued(1, operator.begin()[0])
    operator.on_message(7, ack(Stage.FAILED, reason="timeout"))
    assert [(event.time_ns, event.kind, event.waypoint) for event in events] == [(7, EventKind.WAYPOINT_SKIPPED, 0)]


def test_what_was_thought_of_is_dropped_at_the_end() -> None:
    operator = WaypointOperator(mission_of("operator: {think: 5 s}"))
    operator.on_issued(1, operator.begin()[0])
    operator.on_message(0, ack(Stage.COMPLETED))
    assert operator.wake_ns == 5 * NS_PER_S
    operator.on_message(0, ack(Stage.FAILED, reason="fall"))
    assert operator.finished
    assert operator.wake(9 * NS_PER_S) == []
    assert not operator.acts_on_states


@pytest.mark.parametrize(
    ("start_ns", "arrives_ns", "yields"), [(5, 5, True), (6, 5, False), (6, 6, True), (6, None, True)]
)
def test_the_ground_leads_no_further_once_its_goals_would_arrive_after_a_return_home_begins(
    start_ns: int, arrives_ns: int | None, yields: bool
) -> None:
    operator = WaypointOperator(mission_of(""))
    operator.on_external_request(4, CommandRequest(CommandKind.RETURN_HOME, not_before_ns=start_ns))
    assert not operator.going_home
    operator.yield_to_return(4, lambda _: arrives_ns)
    assert (operator.going_home, operator.suspended) == (yields, yields)


def test_a_waypoint_that_a_way_home_kept_back_is_sent_where_the_robot_does_not_go_home() -> None:
    operator = WaypointOperator(mission_of(""))
    operator.on_issued(1, operator.begin()[0])
    operator.note_kind(2, CommandKind.RETURN_HOME)
    operator.on_external_request(0, CommandRequest(CommandKind.RETURN_HOME))
    assert operator.on_message(0, ack(Stage.COMPLETED)) == []
    assert operator.wake(5) == []
    (request,) = operator.on_message(0, ack(Stage.REJECTED, 2))
    assert request.waypoints[0].name == "WP2"
