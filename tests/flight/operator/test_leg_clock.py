"""A leg that is led from the ground has the robot's time, whatever the link takes."""

from __future__ import annotations

from dataclasses import replace

from tests.flight.flying import UNDER_FOOT, flown, mission_of, only
from tests.flight.operator.missions import ack, frame
from tests.flight.operator.missions import mission_of as mission_text
from waypointctl.flight.operator.planner import ShortRangeGoalOperator
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.flight.operator.timing import LegClock
from waypointctl.log.messages import CommandKind, CommandStatus, Mode, Stage, State
from waypointctl.units import NS_PER_S

RTT_NS = 40 * NS_PER_S


def answer_by(left_ns: int) -> int | None:
    return left_ns + RTT_NS


def goal() -> CommandRequest:
    return CommandRequest(CommandKind.GO_TO)


def started(clock: LegClock, command_id: int, at_s: float, stage: Stage = Stage.STARTED) -> None:
    clock.on_message(ack(stage, command_id, issued_ns=round(at_s * NS_PER_S)))


def test_a_leg_begins_when_its_first_goal_starts_on_board() -> None:
    clock = LegClock(answer_by)
    clock.on_issued(1, clock.include(goal()))
    started(clock, 1, 19.0, Stage.RECEIVED)
    started(clock, 1, 19.0, Stage.ACCEPTED)
    assert clock.began_ns is None
    started(clock, 1, 20.0)
    clock.on_message(frame(issued_ns=30 * NS_PER_S))
    assert not clock.is_over(10 * NS_PER_S)
    clock.on_message(frame(issued_ns=30 * NS_PER_S + 1))
    assert clock.is_over(10 * NS_PER_S)
    started(clock, 2, 35.0)
    assert clock.began_ns == 20 * NS_PER_S, "a later goal begins nothing"


def test_where_the_first_acknowledgement_is_lost_the_next_one_will_do() -> None:
    clock = LegClock(answer_by)
    for command_id in (1, 2):
        clock.on_issued(command_id, clock.include(goal()))
    started(clock, 2, 21.0, Stage.SUPERSEDED)
    assert clock.began_ns == 21 * NS_PER_S


def test_what_others_send_and_goals_of_the_leg_before_begin_no_leg() -> None:
    clock = LegClock(answer_by)
    old = clock.include(goal())
    clock.restart(5 * NS_PER_S)
    clock.on_issued(1, old)
    clock.on_issued(2, CommandRequest(CommandKind.SET_TOLERANCE, value=1.0))
    clock.on_issued(3, clock.include(goal()))
    for command_id in (1, 2):
        started(clock, command_id, 6.0)
    assert clock.began_ns is None
    started(clock, 3, 7.0)
    assert clock.began_ns == 7 * NS_PER_S


def test_a_frame_that_was_overtaken_does_not_set_the_clock_back() -> None:
    clock = LegClock(answer_by)
    clock.on_issued(1, clock.include(goal()))
    started(clock, 1, 20.0)
    clock.on_message(frame(issued_ns=31 * NS_PER_S))
    clock.on_message(frame(issued_ns=22 * NS_PER_S))
    assert clock.is_over(10 * NS_PER_S)


def test_where_nothing_is_told_the_ground_waits_for_as_long_as_an_answer_takes() -> None:
    clock = LegClock(answer_by)
    clock.restart(7 * NS_PER_S)
    latest_ns = 17 * NS_PER_S + RTT_NS
    assert not clock.is_silent(latest_ns, 10 * NS_PER_S)
    assert clock.is_silent(latest_ns + 1, 10 * NS_PER_S)
    no_contact = LegClock(lambda _: None)
    assert no_contact.is_silent(10 * NS_PER_S + 1, 10 * NS_PER_S), "nobody will ever tell"


def test_the_link_takes_nothing_of_the_time_of_a_leg_that_is_steered_continuously() -> None:
    text = "autonomy: short_range_goal\ndefaults: {timeout: 30 s}\noperator: {steering: continuous, update_rate: 1 Hz}"
    operator = ShortRangeGoalOperator(mission_text(text), LegClock(answer_by))
    operator.on_issued(1, operator.begin()[0])
    for second in range(1, 70):
        if second == 40:
            operator.on_message(0, ack(Stage.STARTED, issued_ns=20 * NS_PER_S))
        if second >= 40:
            operator.on_message(0, frame(1.0, 0.0, issued_ns=(second - 20) * NS_PER_S))
        operator.wake(second * NS_PER_S)
        assert not operator.finished, f"{second - 20} s on the robot's clock, 20 s of them before the leg"
    operator.on_message(0, frame(1.0, 0.0, issued_ns=50 * NS_PER_S + 1))
    operator.wake(71 * NS_PER_S)
    assert operator.failure == "timeout"


def test_no_leg_is_given_up_at_a_waypoint_whose_task_is_under_way() -> None:
    text = "autonomy: short_range_goal\ndefaults: {timeout: 3 s, hold: 1 min}\n"
    text += "operator: {steering: continuous, lookahead: 9 m}"
    operator = ShortRangeGoalOperator(mission_text(text))
    operator.on_issued(1, operator.begin()[0])
    operator.on_message(0, ack(Stage.STARTED, issued_ns=0))
    for second in range(1, 50):
        operator.on_message(0, frame(4.0, 0.0, reached=(0,), issued_ns=second * NS_PER_S))
        assert operator.wake(second * NS_PER_S) == []
        assert not operator.finished


def test_a_leg_shorter_than_the_round_trip_can_be_steered() -> None:
    operator = {"steering": "continuous"}
    legs = [UNDER_FOOT | {"timeout_s": 5.0}, UNDER_FOOT | {"timeout_s": 5.0}]
    result, messages = flown(mission_of(*legs, delay_ms=20_000, autonomy="short_range_goal", operator=operator))
    assert (result.outcome, result.waypoints_reached) == ("success", 2)
    assert len(only(State, messages)) < 6000


def test_only_what_the_robot_walks_counts() -> None:
    clock = LegClock(answer_by)
    for command_id in (1, 2, 3):
        clock.on_issued(command_id, clock.include(goal()))
    started(clock, 1, 20.0)
    started(clock, 1, 24.0, Stage.COMPLETED)
    started(clock, 2, 1000.0)
    clock.on_message(frame(issued_ns=1002 * NS_PER_S))
    assert not clock.is_over(6 * NS_PER_S)
    assert clock.is_over(6 * NS_PER_S - 1)
    clock.on_message(frame(mode=Mode.PAUSED, issued_ns=1003 * NS_PER_S))
    clock.on_message(frame(mode=Mode.PAUSED, issued_ns=5000 * NS_PER_S))
    assert not clock.is_over(7 * NS_PER_S)
    clock.on_message(frame(issued_ns=5001 * NS_PER_S))
    started(clock, 2, 5002.0, Stage.SUPERSEDED)
    started(clock, 3, 5002.0)
    clock.on_message(frame(issued_ns=5004 * NS_PER_S))
    assert not clock.is_over(10 * NS_PER_S)
    assert clock.is_over(10 * NS_PER_S - 1)


def test_an_acknowledgement_that_was_overtaken_starts_nothing_again() -> None:
    clock = LegClock(answer_by)
    clock.on_issued(1, clock.include(goal()))
    started(clock, 1, 24.0, Stage.COMPLETED)
    started(clock, 1, 20.0)
    clock.on_message(frame(issued_ns=900 * NS_PER_S))
    assert not clock.is_over(NS_PER_S)


def test_a_contact_that_is_still_to_come_is_waited_for() -> None:
    opens_ns = 1800 * NS_PER_S
    clock = LegClock(answer_by, lambda sent_ns: max(sent_ns, opens_ns))
    clock.restart(0)
    assert not clock.is_silent(opens_ns + RTT_NS + 10 * NS_PER_S, 10 * NS_PER_S)
    assert clock.is_silent(opens_ns + RTT_NS + 10 * NS_PER_S + 1, 10 * NS_PER_S)


def test_a_leg_that_is_begun_anew_keeps_nothing_of_the_one_before() -> None:
    clock = LegClock(answer_by)
    clock.on_issued(1, clock.include(goal()))
    started(clock, 1, 2.0)
    clock.restart(5 * NS_PER_S)
    started(clock, 1, 6.0, Stage.SUPERSEDED)
    assert clock.began_ns is None
    clock.on_issued(2, clock.include(goal()))
    started(clock, 2, 20.0)
    clock.on_message(frame(issued_ns=30 * NS_PER_S))
    assert not clock.is_over(10 * NS_PER_S)
    assert clock.is_over(10 * NS_PER_S - 1)


def test_a_goal_that_was_dropped_before_it_was_sent_is_none_of_the_leg() -> None:
    clock = LegClock(answer_by)
    dropped, sent, last = (clock.include(goal()) for _ in range(3))
    clock.on_issued(1, sent)
    clock.on_issued(2, dropped)
    started(clock, 2, 6.0)
    assert clock.began_ns is None
    clock.on_issued(3, last)
    started(clock, 3, 7.0)
    assert clock.began_ns == 7 * NS_PER_S


def test_a_frame_reports_goals_too() -> None:
    clock = LegClock(answer_by)
    clock.on_issued(1, clock.include(goal()))
    clock.on_message(replace(frame(issued_ns=3 * NS_PER_S), commands=(CommandStatus(1, Stage.STARTED),)))
    assert clock.began_ns == 3 * NS_PER_S


def test_a_frame_of_the_same_moment_is_news() -> None:
    clock = LegClock(answer_by)
    clock.on_issued(1, clock.include(goal()))
    started(clock, 1, 20.0)
    for second in (20, 40):
        clock.on_message(frame(mode=Mode.PAUSED, issued_ns=second * NS_PER_S))
    assert not clock.is_over(0)


def test_a_robot_that_drives_for_others_takes_nothing_of_the_legs_time() -> None:
    clock = LegClock(answer_by)
    for second in (5, 50):
        clock.on_message(frame(issued_ns=second * NS_PER_S))
    assert not clock.is_over(0)
    clock.on_issued(1, clock.include(goal()))
    started(clock, 1, 60.0)
    started(clock, 1, 60.0, Stage.COMPLETED)
    for second in (70, 90):
        clock.on_message(frame(issued_ns=second * NS_PER_S))
    assert not clock.is_over(0), "its goal has ended"


def test_what_is_acknowledged_once_more_is_no_change() -> None:
    clock = LegClock(answer_by)
    clock.on_issued(1, clock.include(goal()))
    overdue_ns = 30 * NS_PER_S + RTT_NS + 1
    started(clock, 1, 20.0)
    started(clock, 1, 25.0)
    assert clock.is_silent(overdue_ns, 10 * NS_PER_S)
    assert not clock.is_silent(overdue_ns - 1, 10 * NS_PER_S)
    started(clock, 1, 30.0, Stage.COMPLETED)
    started(clock, 1, 35.0, Stage.COMPLETED)
    assert clock.is_silent(overdue_ns + 10 * NS_PER_S, 10 * NS_PER_S)
    assert not clock.is_silent(overdue_ns + 10 * NS_PER_S - 1, 10 * NS_PER_S)
