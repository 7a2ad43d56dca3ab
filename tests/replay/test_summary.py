from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.replay.hand_made import FAR, NEAR, ack, event, flight, frame, stage, state
from waypointctl.log.messages import (
    Clock,
    Command,
    CommandKind,
    EventKind,
    Message,
    PlannedWaypoint,
    Stage,
    State,
    Telemetry,
)
from waypointctl.replay.legs import WaypointStatus
from waypointctl.replay.summary_builder import FlightSummaryBuilder, summarize
from waypointctl.replay.track import Track
from waypointctl.units import ns


def test_the_outcome_is_what_the_operator_said_last() -> None:
    summary = summarize(flight())
    assert (summary.outcome, summary.reason) == ("failure", "timeout: 1 of 2 waypoints reached")
    assert summary.ended_ns == ns(5.0)
    assert summary.steps == 10


def test_the_headline_keeps_what_is_known_apart_from_what_is_true() -> None:
    messages = [*flight()][:-1]
    ended = event(5, EventKind.MISSION_ENDED, "interrupted: 0 of 2 waypoints known to be reached", Clock.OPERATOR)
    assert summarize([*messages, ended]).headline == ended.text, "both know of one"
    lost_spans = [message for message in messages if not isinstance(message, Telemetry)]
    assert summarize([*lost_spans, ended]).headline == f"{ended.text}; the robot reached 1, the operator knows of 0"
    assert summarize(lost_spans).headline == "unfinished: the log has no end"


def test_a_command_is_told_on_both_clocks() -> None:
    (command,) = summarize(flight()).commands
    assert (command.id, command.description) == (1, "upload_plan near, far")
    assert (command.issued_ns, command.received_ns) == (0, ns(1.0))
    assert (command.acknowledged_ns, command.round_trip_ns) == (ns(2.0), ns(2.0))
    assert (command.uplink_ns, command.downlink_ns) == (ns(1.0), ns(1.0))
    assert (command.onboard, command.ended_ns) == (Stage.FAILED, ns(4.0))
    assert (command.known_stage, command.end_known_ns) == (Stage.FAILED, ns(5.0))
    assert [one.stage for one in command.acks] == [Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED, Stage.FAILED]


def test_a_waypoint_is_reached_on_one_clock_and_known_on_the_other() -> None:
    near, far = summarize(flight()).waypoints
    assert (near.planned, near.status) == (NEAR, WaypointStatus.REACHED)
    assert (near.started_ns, near.reached_ns, near.ended_ns, near.known_ns) == (ns(1), ns(2), ns(2), ns(3))
    assert (far.planned, far.status) == (FAR, WaypointStatus.TIMED_OUT)
    assert (far.started_ns, far.reached_ns, far.ended_ns, far.known_ns) == (ns(2), None, ns(4), None)


def test_effort_by_hand() -> None:
    effort = summarize(flight()).effort
    # 0 to 6 m in the six steps of the policy, then a slide of 0.3 m along x and of 0.4 m along y.
    assert effort.moved_m == pytest.approx(6.0)
    assert effort.distance_m == pytest.approx(6.0 + 0.3 + 0.4)
    assert (effort.moving_ns, effort.stopped_ns, effort.fallen_ns) == (ns(3.0), ns(2.0), 0)
    assert effort.mean_speed_mps == pytest.approx(2.0)
    assert effort.stopped_share == pytest.approx(0.4)


def test_reward_terms_are_summed() -> None:
    summary = summarize(flight())
    assert dict(summary.reward) == {"progress": pytest.approx(8.0), "energy": pytest.approx(-2.5)}
    assert summary.reward_total == pytest.approx(5.5)


def test_truth_and_belief_each_have_their_time() -> None:
    summary = summarize(flight())
    np.testing.assert_array_equal(summary.truth.x_m, [0, 0, 0, 1, 2, 3, 4, 5, 6, 6.3, 6.3])
    np.testing.assert_array_equal(summary.truth.known_ns, summary.truth.time_ns)
    np.testing.assert_array_equal(summary.truth.speed_mps, [0, 0, 2, 2, 2, 2, 2, 2, 0, 0, 0])
    np.testing.assert_array_equal(summary.belief.time_ns, [ns(0.0), ns(2.0)])
    np.testing.assert_array_equal(summary.belief.known_ns, [ns(1.0), ns(3.0)])
    np.testing.assert_array_equal(summary.belief.x_m, [0.0, 2.0])


def test_a_summary_can_be_asked_for_while_the_flight_goes_on() -> None:
    builder = FlightSummaryBuilder((NEAR, FAR))
    for message in flight():
        if isinstance(message, Command):
            break
        builder(message)
    (command,) = builder.commands
    assert (command.onboard, command.known_stage, command.received_ns, command.round_trip_ns) == (
        None,
        Stage.SENT,
        None,
        None,
    )
    assert command.description == "upload_plan near, far"
    assert [waypoint.status for waypoint in builder.waypoints] == [WaypointStatus.OPEN, WaypointStatus.OPEN]
    assert builder.now_ns == ns(1.0)
    assert builder.summary().outcome == "unfinished"


def test_between_arrival_and_hearing_the_robot_is_ahead_of_the_operator() -> None:
    builder = FlightSummaryBuilder((NEAR, FAR))
    told = list(flight())
    upto = next(i for i, m in enumerate(told) if getattr(m, "kind", None) is EventKind.COMMAND_RECEIVED)
    for message in told[: upto + 1]:
        builder(message)
    (command,) = builder.commands
    assert (command.onboard, command.known_stage) == (Stage.RECEIVED, Stage.SENT)


def test_nothing_happened() -> None:
    summary = summarize([])
    assert (summary.outcome, summary.steps, summary.ended_ns, len(summary.truth)) == ("unfinished", 0, 0, 0)
    assert summary.effort.mean_speed_mps is None
    assert summary.effort.stopped_share is None


def test_waypoints_that_were_never_commanded_are_open() -> None:
    beyond = PlannedWaypoint(2, "beyond", 9.0, 9.0, "box", 0.5, 1, 0)
    summary = summarize(flight(), (NEAR, FAR, beyond))
    assert [waypoint.status for waypoint in summary.waypoints] == [
        WaypointStatus.REACHED,
        WaypointStatus.TIMED_OUT,
        WaypointStatus.OPEN,
    ]
    assert (summary.reached, summary.known) == (1, 1)


def test_a_skipped_waypoint_says_so() -> None:
    skipped = event(4.0, EventKind.WAYPOINT_SKIPPED, "far skipped", waypoint=1, command_id=1)
    assert summarize([*flight(), skipped]).waypoints[1].status is WaypointStatus.SKIPPED


def test_a_fall_ends_the_leg_and_the_command() -> None:
    messages: list[Message] = [
        event(0, EventKind.COMMAND_SENT, "command 1 sent: go_to near", Clock.OPERATOR, command_id=1),
        Command(1, CommandKind.GO_TO, (NEAR,), "abort", 0, ns(1.0)),
        event(1, EventKind.COMMAND_RECEIVED, "received", command_id=1),
        event(1, EventKind.LEG_STARTED, "driving to near", waypoint=0, command_id=1),
        event(3, EventKind.FALL, "the robot has fallen", command_id=1),
        stage(3, Stage.FAILED, reason="fall"),
    ]
    summary = summarize(messages)
    assert summary.falls == 1
    assert summary.waypoints[0].ended_ns == ns(3.0)
    assert summary.waypoints[0].status is WaypointStatus.OPEN
    assert (summary.commands[0].onboard, summary.commands[0].ended_ns) == (Stage.FAILED, ns(3.0))


@pytest.mark.parametrize(
    ("kind", "ends"),
    [
        (EventKind.RETURN_STARTED, True),
        (EventKind.PLAN_FAILED, True),
        (EventKind.TELEOPERATION_STARTED, True),
        (EventKind.LEG_STARTED, True),  # of another waypoint
        (EventKind.NAVIGATION_PAUSED, False),
        (EventKind.LEG_RETRIED, False),
    ],
)
def test_a_leg_ends_when_the_robot_does_something_else(kind: EventKind, ends: bool) -> None:
    begun = event(1, EventKind.LEG_STARTED, "driving to near", waypoint=0)
    summary = summarize([begun, event(3, kind, "", waypoint=1)], (NEAR, FAR))
    assert summary.waypoints[0].ended_ns == (ns(3.0) if ends else None)


def test_nothing_follows_the_end_of_a_command() -> None:
    messages: list[Message] = [
        stage(0, Stage.QUEUED, Clock.OPERATOR),
        stage(2, Stage.COMPLETED),
        stage(3, Stage.FAILED, reason="fall"),
    ]
    (command,) = summarize(messages).commands
    assert (command.onboard, command.ended_ns) == (Stage.COMPLETED, ns(2.0))


def test_a_command_that_was_lost_and_sent_again_says_so() -> None:
    messages: list[Message] = [
        stage(0, Stage.QUEUED, Clock.OPERATOR),
        stage(0, Stage.SENT, Clock.OPERATOR),
        stage(0, Stage.LOST, Clock.LINK, "lost on the way"),
        stage(3, Stage.UNKNOWN, Clock.OPERATOR, "no acknowledgement"),
        stage(3, Stage.QUEUED, Clock.OPERATOR, attempt=2),
        stage(3, Stage.SENT, Clock.OPERATOR, attempt=2),
        Command(1, CommandKind.GO_TO, (NEAR,), "abort", ns(3.0), ns(4.0), attempt=2),
        stage(4, Stage.RECEIVED, attempt=2),
        ack(Stage.RECEIVED, 4.0),
    ]
    (command,) = summarize(messages).commands
    assert (command.attempts, command.losses) == (2, 1)
    assert (command.issued_ns, command.received_ns) == (0, ns(4.0)), "from the first sending on"
    assert command.uplink_ns == ns(1.0), "of the one that arrived"
    assert command.round_trip_ns == ns(2.0), "of the same sending"
    assert command.onboard is Stage.RECEIVED


def test_the_round_trip_is_of_the_sending_that_was_acknowledged() -> None:
    """Both sendings arrive; of the first one the acknowledgement is lost."""
    first = Command(1, CommandKind.GO_TO, (NEAR,), "abort", 0, ns(1.0), attempt=1)
    second = replace(first, issued_ns=ns(3.0), received_ns=ns(4.0), attempt=2)
    (command,) = summarize([first, second, ack(Stage.RECEIVED, 4.0)]).commands
    assert (command.received_ns, command.round_trip_ns) == (ns(1.0), ns(2.0))
    (command,) = summarize([first, ack(Stage.RECEIVED, 1.0), second]).commands
    assert command.round_trip_ns == ns(2.0), "a sending that arrives later changes nothing"


def test_a_rejected_command_is_concluded() -> None:
    (command,) = summarize([ack(Stage.RECEIVED, 1.0), ack(Stage.REJECTED, 1.0, "fall")]).commands
    assert (command.known_stage, command.end_known_ns) == (Stage.REJECTED, ns(2.0))


def test_a_waypoint_is_learned_of_once() -> None:
    later = [frame(n, 2.0 + n, 2.0, (0,)) for n in (1, 2)]
    (near,) = summarize(later, (NEAR,)).waypoints
    assert near.known_ns == ns(4.0)


def test_a_thinned_track_keeps_both_ends() -> None:
    rows = np.arange(1001)
    meters = rows.astype(np.float64)
    track = Track(rows, rows, meters, 2 * meters, meters)
    thin = track.thinned(10)
    assert len(thin) <= 11
    assert (thin.time_ns[0], thin.time_ns[-1]) == (0, 1000)
    np.testing.assert_array_equal(thin.y_m, 2.0 * thin.x_m)
    assert len(track.thinned(5000)) == 1001


def test_of_frames_that_overtake_each_other_only_those_are_news_that_were_sampled_later() -> None:
    frames = [frame(n, issued_s, issued_s, ()) for n, issued_s in enumerate((0.0, 2.0, 1.0, 2.0, 3.0))]
    belief = summarize(frames).belief
    assert belief.newest().x_m.tolist() == [0.0, 2.0, 3.0]
    assert belief.newest().last().x_m.tolist() == [3.0]
    assert len(summarize([]).belief.newest().last()) == 0


def test_rows_are_found_by_their_times() -> None:
    rows = np.arange(5)
    meters = rows.astype(np.float64)
    track = Track(rows, rows, meters, meters, meters)
    assert track.between(1, 3).time_ns.tolist() == [1, 2, 3]
    assert track.nearest(np.array([-7, 0, 3, 99])).time_ns.tolist() == [0, 0, 3, 4]
    assert len(track.at(np.array([], np.int64)).nearest(np.array([1]))) == 0


def test_when_the_robot_moved_and_when_physics_slept() -> None:
    rest = (event(4.5, EventKind.REST_STARTED, "rests"), event(9, EventKind.REST_ENDED, "wakes"))
    summary = summarize([*flight(), *rest])
    assert summary.moving == ((ns(1.0), ns(4.0)),)
    assert summary.resting == ((ns(4.5), ns(9.0)),)
    assert summarize([*flight(), rest[0]]).resting == ((ns(4.5), ns(5.0)),)  # until the end


def test_the_way_so_far_is_bounded_and_ends_where_the_robot_is() -> None:
    builder = FlightSummaryBuilder()
    for step in range(997):
        builder(state(step, step * 0.1, -step * 0.1, 0.0))
    truth = builder.truth(100)
    assert 100 <= len(truth) <= 120
    assert (truth.x_m[0], truth.x_m[-1]) == (0.0, pytest.approx(99.6))
    np.testing.assert_array_equal(truth.y_m, -truth.x_m)


def test_a_place_that_no_map_has_is_left_out_and_its_time_is_kept() -> None:
    def lost(message: Message) -> Message:
        if isinstance(message, State) and message.step == 3:
            return replace(message, qpos=np.full(7, np.nan))
        return replace(message, x_m=np.inf) if isinstance(message, Telemetry) and message.frame == 1 else message

    whole, summary = summarize(flight()), summarize(map(lost, flight()))
    assert (summary.states_off_map, summary.frames_off_map) == (1, 1)
    assert (len(summary.truth), len(summary.belief)) == (len(whole.truth) - 1, len(whole.belief) - 1)
    # It walks straight on along x while it is lost, so that neither way nor time is lost with it.
    assert summary.effort == whole.effort
    assert summary.known == whole.known == 1


def test_the_newest_commands_are_those_of_all_commands() -> None:
    builder = FlightSummaryBuilder()
    for message in flight():
        builder(message)
        for most in (0, 1, 2, 5):
            assert builder.newest_commands(most) == builder.commands[len(builder.commands) - most :][-most:]
        trips = [command.round_trip_ns for command in builder.commands if command.round_trip_ns is not None]
        assert builder.round_trip_ns == (trips[-1] if trips else None)
