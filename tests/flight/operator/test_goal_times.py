"""Short-range goals: when each is sent, over holds, tasks and legs that are given up."""

from __future__ import annotations

import pytest

from tests.flight.operator.missions import ack, frame, mission_of
from waypointctl.flight.operator.planner import ShortRangeGoalOperator
from waypointctl.flight.operator.requests import LOOKAHEAD, CommandRequest
from waypointctl.log.messages import CommandKind, Event, EventKind, Stage
from waypointctl.units import NS_PER_S

HOLD, RESUME = CommandRequest(CommandKind.HOLD), CommandRequest(CommandKind.RESUME)
CONTINUOUS = "operator: {steering: continuous, update_rate: 1 Hz, lookahead: 1 m}"


def steering(text: str, waypoints: str = "[[4, 0], [4, 3]]") -> tuple[ShortRangeGoalOperator, list[Event]]:
    events: list[Event] = []
    mission = mission_of(f"autonomy: short_range_goal\n{text}", waypoints)
    return ShortRangeGoalOperator(mission, announce=events.append), events


def begun(text: str, waypoints: str = "[[4, 0], [4, 3]]") -> tuple[ShortRangeGoalOperator, list[Event]]:
    operator, events = steering(text, waypoints)
    (first,) = operator.begin()
    operator.on_issued(1, first)
    return operator, events


def indices(requests: list[CommandRequest]) -> list[int]:
    return [request.waypoints[0].index for request in requests]


# Holds


def test_a_goal_that_a_hold_kept_back_is_sent_once_when_it_is_resumed() -> None:
    operator, _ = begun("")
    operator.on_external_request(0, HOLD)
    assert operator.on_external_request(0, RESUME) == [], "no goal was due"
    operator.on_external_request(0, HOLD)
    assert operator.on_message(0, ack(Stage.COMPLETED)) == []
    assert indices(operator.on_external_request(0, RESUME)) == [LOOKAHEAD]
    operator.on_external_request(0, HOLD)
    assert operator.on_external_request(0, RESUME) == []


def test_updates_that_a_hold_kept_back_are_not_made_up_for() -> None:
    operator, _ = begun(CONTINUOUS)
    assert len(operator.wake(NS_PER_S)) == 1
    operator.on_external_request(NS_PER_S, HOLD)
    assert operator.wake_ns is None
    operator.on_external_request(5 * NS_PER_S + 1, RESUME)
    assert operator.wake_ns == 6 * NS_PER_S


def test_a_leg_has_its_whole_time_again_after_a_hold() -> None:
    operator, _ = begun("defaults: {timeout: 30 s}\n" + CONTINUOUS)
    operator.on_message(0, ack(Stage.STARTED, issued_ns=0))
    operator.on_message(0, frame(issued_ns=25 * NS_PER_S))
    operator.on_external_request(25 * NS_PER_S, HOLD)
    operator.on_external_request(26 * NS_PER_S, RESUME)
    (goal,) = operator.wake(27 * NS_PER_S)
    operator.on_issued(2, goal)
    operator.on_message(0, ack(Stage.STARTED, 2, issued_ns=28 * NS_PER_S))
    operator.on_message(0, frame(issued_ns=40 * NS_PER_S))
    assert len(operator.wake(40 * NS_PER_S)) == 1
    operator.on_message(0, frame(issued_ns=58 * NS_PER_S + 1))
    operator.wake(59 * NS_PER_S)
    assert operator.failure == "timeout"


def test_a_return_home_that_ends_before_its_time_does_not_end_a_hold() -> None:
    operator, _ = begun("")
    operator.note_kind(2, CommandKind.RETURN_HOME)
    operator.on_external_request(0, CommandRequest(CommandKind.RETURN_HOME, not_before_ns=9 * NS_PER_S))
    operator.on_external_request(0, HOLD)
    assert operator.on_message(0, ack(Stage.COMPLETED)) == []
    assert operator.on_message(0, ack(Stage.CANCELLED, 2)) == []
    assert operator.suspended
    assert indices(operator.on_external_request(0, RESUME)) == [LOOKAHEAD]


# Updates


def test_the_first_of_an_update_and_a_thought_wakes_the_operator() -> None:
    operator, _ = begun(CONTINUOUS.replace("}", ", think: 2500 ms}"))
    assert operator.wake_ns == NS_PER_S
    assert operator.wake(NS_PER_S) == []
    assert operator.wake_ns == 2 * NS_PER_S
    operator.wake(2 * NS_PER_S)
    operator.wake(3 * NS_PER_S)
    assert operator.wake_ns == 3_500_000_000


def test_a_leg_begins_for_the_ground_when_its_first_goal_is_sent() -> None:
    text = "defaults: {timeout: 3 s}\n" + CONTINUOUS.replace("}", ", think: 2 s}")
    operator, _ = begun(text)
    operator.on_message(0, frame(4.0, 0.0, reached=(0,)))
    for second in range(1, 7):
        operator.wake(second * NS_PER_S)
        assert not operator.finished, "sent at 3 s, with 3 s of time"
    operator.wake(7 * NS_PER_S)
    assert operator.failure == "timeout"


@pytest.mark.parametrize("steered", ["continuous", "move_and_wait"])
def test_the_end_of_another_command_makes_no_goal(steered: str) -> None:
    operator, _ = begun(f"operator: {{steering: {steered}}}")
    assert operator.on_message(0, ack(Stage.COMPLETED, 9)) == []
    assert indices(operator.on_message(0, ack(Stage.COMPLETED))) == ([] if steered == "continuous" else [LOOKAHEAD])


def test_a_leg_is_over_time_by_the_robots_clock_when_its_goal_is() -> None:
    operator, _ = begun("defaults: {timeout: 30 s}")
    operator.on_message(0, ack(Stage.STARTED, issued_ns=5 * NS_PER_S))
    operator.on_message(0, frame(issued_ns=35 * NS_PER_S + 1))
    assert operator.on_message(0, ack(Stage.COMPLETED, issued_ns=35 * NS_PER_S + 2)) == []
    assert operator.failure == "timeout"


@pytest.mark.parametrize(
    ("then", "reason", "failure"),
    [("skip", "timeout", ""), ("skip", "geofence", "geofence"), ("abort", "stuck", "stuck")],
)
def test_a_goal_that_failed_is_followed_by_the_next_leg_or_the_end(then: str, reason: str, failure: str) -> None:
    operator, events = begun(f"on_failure: {then}")
    operator.on_message(0, frame(4.0, 1.0))
    requests = operator.on_message(0, ack(Stage.FAILED, reason=reason))
    assert (operator.finished, operator.failure) == (bool(failure), failure)
    assert [request.waypoints[0].name for request in requests] == ([] if failure else ["towards WP2"])
    skipped = [(event.kind, event.waypoint) for event in events]
    assert skipped == ([] if failure else [(EventKind.WAYPOINT_SKIPPED, 0)])


# Tasks


def test_a_waypoint_within_the_lookahead_is_sent_itself() -> None:
    operator, _ = steering("operator: {lookahead: 4 m}")
    assert indices(operator.begin()) == [0]
    operator, _ = steering("operator: {lookahead: 3.99 m}")
    (request,) = operator.begin()
    assert (request.waypoints[0].index, request.waypoints[0].hold_ns) == (-1, 0)


@pytest.mark.parametrize(
    ("steered", "task", "transient"),
    [
        ("continuous", "", True),
        ("continuous", ", hold: 2 s", False),
        ("continuous", ", observe: true", False),
        ("move_and_wait", "", False),
        ("move_and_wait", ", hold: 2 s", False),
    ],
)
def test_only_a_goal_that_the_next_update_replaces_is_transient(steered: str, task: str, transient: bool) -> None:
    text = f"operator: {{steering: {steered}, lookahead: 9 m}}"
    operator, _ = steering(text, f"[{{position_m: [4, 0]{task}}}, [4, 3]]")
    assert [request.transient for request in operator.begin()] == [transient]


def test_the_end_of_a_task_begins_the_next_leg_under_continuous_steering() -> None:
    text = "operator: {steering: continuous, update_rate: 1 Hz, lookahead: 9 m}"
    operator, _ = begun(text, "[{position_m: [4, 0], hold: 2 s}, [4, 3]]")
    assert operator.wake_ns is None
    operator.on_message(0, frame(4.0, 0.0, reached=(0,)))
    assert operator.on_message(5 * NS_PER_S + 1, ack(Stage.COMPLETED)) == []
    assert operator.wake_ns == 6 * NS_PER_S, "the updates during the task are left out"
    assert indices(operator.wake(6 * NS_PER_S)) == [1]
