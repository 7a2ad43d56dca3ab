from __future__ import annotations

import math

import pytest

from tests.flight.operator.missions import ack, frame, mission_of
from waypointctl.flight.operator.planner import ShortRangeGoalOperator
from waypointctl.flight.operator.requests import LOOKAHEAD, CommandRequest
from waypointctl.log.messages import CommandKind, Stage
from waypointctl.units import NS_PER_S


def steering(text: str = "") -> ShortRangeGoalOperator:
    return ShortRangeGoalOperator(mission_of(f"autonomy: short_range_goal\n{text}"))


def place(request: CommandRequest) -> tuple[int, float, float]:
    assert request.kind is CommandKind.GO_TO
    (waypoint,) = request.waypoints
    return waypoint.index, waypoint.x_m, waypoint.y_m


def test_the_goal_lies_ahead_of_the_believed_pose_and_the_waypoint_itself_is_sent_when_near() -> None:
    operator = steering("operator: {lookahead: 1.5 m}")
    assert [place(request) for request in operator.begin()] == [(LOOKAHEAD, 1.5, 0.0)]
    operator.on_issued(1, operator._lookahead_goal())
    operator.on_message(0, frame(1.0, 3.0))
    index, x_m, y_m = place(operator.on_message(0, ack(Stage.COMPLETED))[0])
    assert index == LOOKAHEAD
    assert math.dist((x_m, y_m), (1.0, 3.0)) == pytest.approx(1.5)
    assert (y_m - 3.0) / (x_m - 1.0) == pytest.approx(-1.0), "towards (4, 0)"
    operator.on_message(0, frame(3.0, 0.5))
    assert place(operator.on_message(0, ack(Stage.COMPLETED))[0]) == (0, 4.0, 0.0)


def test_a_short_range_goal_is_reached_within_a_quarter_of_its_distance() -> None:
    (request,) = steering("operator: {lookahead: 1 m}").begin()
    assert request.waypoints[0].tolerance_m == 0.25
    (request,) = steering("operator: {lookahead: 3 m}").begin()
    assert request.waypoints[0].tolerance_m == 0.5, "never wider than the waypoint's own"


def test_move_and_wait_sends_one_at_a_time_and_thinks_first() -> None:
    operator = steering("operator: {think: 2 s}")
    operator.on_issued(1, operator.begin()[0])
    assert operator.wake_ns is None
    assert operator.on_message(0, frame(1.0, 0.0)) == []
    assert operator.on_message(5, ack(Stage.STARTED)) == []
    assert operator.on_message(10, ack(Stage.COMPLETED)) == []
    assert operator.wake_ns == 10 + 2 * NS_PER_S
    (request,) = operator.wake(10 + 2 * NS_PER_S)
    assert place(request) == (LOOKAHEAD, 2.0, 0.0)
    assert operator.wake_ns is None


def test_the_next_leg_begins_when_the_robot_has_reported_the_waypoint() -> None:
    operator = steering()
    operator.on_issued(1, operator.begin()[0])
    operator.on_message(0, frame(4.0, 0.0, reached=(0,)))
    (request,) = operator.on_message(0, ack(Stage.COMPLETED))
    assert place(request) == (LOOKAHEAD, 4.0, 1.0)
    operator.on_issued(2, request)
    operator.on_message(0, frame(4.0, 3.0, reached=(0, 1)))
    assert operator.on_message(0, ack(Stage.COMPLETED, 2)) == []
    assert operator.finished
    assert operator.failure == ""
    assert operator.wake_ns is None


def test_continuous_steering_sends_at_its_rate_from_what_it_believes_then() -> None:
    operator = steering("operator: {steering: continuous, update_rate: 2 Hz, lookahead: 1 m}")
    operator.begin()
    assert operator.wake_ns == NS_PER_S // 2
    operator.on_message(0, frame(2.0, 0.0))
    assert [place(request) for request in operator.wake(NS_PER_S // 2)] == [(LOOKAHEAD, 3.0, 0.0)]
    assert operator.wake_ns == NS_PER_S
    assert operator.on_message(NS_PER_S - 1, ack(Stage.SUPERSEDED)) == [], "a goal that was replaced is no news"
    operator.on_message(NS_PER_S - 1, frame(4.0, 0.0, reached=(0,)))
    assert [place(request) for request in operator.wake(NS_PER_S)] == [(LOOKAHEAD, 4.0, 1.0)]
    operator.on_message(NS_PER_S, frame(4.0, 3.0, reached=(0, 1)))
    assert operator.finished
    assert operator.wake_ns is None


def test_a_leg_that_takes_longer_than_its_timeout_is_given_up_or_skipped() -> None:
    for policy, finished in (("abort", True), ("skip", False)):
        operator = steering(
            f"on_failure: {policy}\ndefaults: {{timeout: 3 s}}\noperator: {{steering: continuous, update_rate: 1 Hz}}"
        )
        operator.begin()
        for second in range(1, 5):
            requests = operator.wake(second * NS_PER_S)
        assert operator.finished is finished
        if finished:
            assert operator.failure == "timeout"
        else:
            assert place(operator.wake(5 * NS_PER_S)[0])[2] > 0, "towards the second waypoint"
        del requests


def test_a_fall_ends_the_mission() -> None:
    operator = steering("operator: {steering: continuous}")
    operator.on_issued(1, operator.begin()[0])
    assert operator.on_message(0, ack(Stage.FAILED, reason="fall")) == []
    assert (operator.finished, operator.failure) == (True, "fall")


@pytest.mark.parametrize("steering_kind", ["continuous", "move_and_wait"])
def test_no_goal_follows_a_way_home_that_somebody_else_commands(steering_kind: str) -> None:
    operator = steering(f"operator: {{steering: {steering_kind}}}")
    operator.on_issued(1, operator.begin()[0])
    operator.note_kind(2, CommandKind.RETURN_HOME)
    assert operator.on_external_request(NS_PER_S // 2, CommandRequest(CommandKind.RETURN_HOME)) == []
    assert operator.wake_ns is None
    assert operator.wake(5 * NS_PER_S) == []
    assert operator.on_message(6 * NS_PER_S, ack(Stage.COMPLETED, 2)) == []
    assert operator.finished
    assert "return_home" in operator.failure


def test_goals_go_on_where_the_robot_does_not_go_home() -> None:
    operator = steering("operator: {steering: continuous}")
    operator.on_issued(1, operator.begin()[0])
    operator.note_kind(2, CommandKind.RETURN_HOME)
    operator.on_external_request(0, CommandRequest(CommandKind.RETURN_HOME, not_before_ns=9 * NS_PER_S))
    assert not operator.suspended, "the way home is still to come"
    operator.on_external_request(0, CommandRequest(CommandKind.RETURN_HOME))
    operator.on_message(0, ack(Stage.EXPIRED, 2))
    assert not operator.suspended
    assert operator.wake(NS_PER_S) != []
