from __future__ import annotations

import json

import numpy as np
import pytest

from tests.flight.flying import (
    MS,
    OUT_OF_REACH,
    STILL,
    TICK_NS,
    TUMBLE,
    UNDER_FOOT,
    Scripted,
    flown,
    mission_of,
    next_tick,
    only,
    times_ns,
)
from waypointctl.flight.fly import fly
from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Command,
    CommandKind,
    Event,
    EventKind,
    Message,
    Mode,
    Observation,
    Reward,
    Stage,
    State,
    Telemetry,
)
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import stance_action

DELAYS_MS = [0.0, 7.0, 20.0, 130.5, 400.0, 1280.0, 3000.0]


@pytest.mark.parametrize("delay_ms", DELAYS_MS)
def test_with_autonomy_waypoint_each_waypoint_costs_a_round_trip(delay_ms: float) -> None:
    mission = mission_of(UNDER_FOOT, UNDER_FOOT, UNDER_FOOT, autonomy="waypoint", delay_ms=delay_ms)
    result, messages = flown(mission)
    started, reached = times_ns(EventKind.LEG_STARTED, messages), times_ns(EventKind.WAYPOINT_REACHED, messages)
    assert result.outcome == "success"
    assert len(started) == len(reached) == 3
    round_trip_ns = round(2 * delay_ms * MS)
    for there, onward in zip(reached, started[1:], strict=False):
        assert onward == next_tick(there + round_trip_ns)
        assert 0 <= onward - there - round_trip_ns < TICK_NS
    assert [command.kind for command in only(Command, messages)] == [CommandKind.GO_TO] * 3


@pytest.mark.parametrize("delay_ms", DELAYS_MS)
def test_with_autonomy_mission_the_robot_never_waits(delay_ms: float) -> None:
    result, messages = flown(mission_of(UNDER_FOOT, UNDER_FOOT, UNDER_FOOT, delay_ms=delay_ms))
    started, reached = times_ns(EventKind.LEG_STARTED, messages), times_ns(EventKind.WAYPOINT_REACHED, messages)
    assert started[0] == next_tick(round(delay_ms * MS))
    assert started[1:] == reached[:-1]
    assert result.sim_time_ns == reached[-1] + round(delay_ms * MS), "the operator hears of it a delay later"
    assert [command.kind for command in only(Command, messages)] == [CommandKind.UPLOAD_PLAN]


def test_every_message_over_the_link_takes_the_links_delay() -> None:
    link = {"up": {"delay_s": 0.7}, "down": {"delay_s": 0.33}}
    _, messages = flown(mission_of(UNDER_FOOT, OUT_OF_REACH, autonomy="waypoint", link=link))
    assert {c.received_ns - c.issued_ns for c in only(Command, messages)} == {700 * MS}
    assert {ack.received_ns - ack.issued_ns for ack in only(Ack, messages)} == {330 * MS}
    assert {frame.received_ns - frame.issued_ns for frame in only(Telemetry, messages)} == {330 * MS}


def test_jitter_stays_within_its_bounds_and_keeps_the_order() -> None:
    way = {"delay_s": 0.5, "jitter_s": 0.3}
    _, messages = flown(mission_of(OUT_OF_REACH | {"timeout_s": 8.0}, link={"up": way, "down": way}))
    heard = only(Telemetry, messages)
    delays = [frame.received_ns - frame.issued_ns for frame in heard]
    assert 200 * MS <= min(delays) < max(delays) <= 800 * MS
    assert [frame.frame for frame in heard] == list(range(len(heard)))
    assert len(heard) >= 40


def test_the_operator_acts_on_what_it_has_heard_and_never_before() -> None:
    _, messages = flown(mission_of(UNDER_FOOT, UNDER_FOOT, autonomy="waypoint", delay_ms=500.0))
    completed = [ack for ack in only(Ack, messages) if ack.stage is Stage.COMPLETED]
    first, second = only(Command, messages)
    assert first.issued_ns == 0
    assert second.issued_ns == completed[0].received_ns, "sent when the first had been heard of, not when it was so"
    ended = next(event for event in only(Event, messages) if event.kind is EventKind.MISSION_ENDED)
    assert ended.time_ns == completed[1].received_ns


def test_the_operator_hears_of_the_waypoints_before_the_verdict() -> None:
    _, messages = flown(mission_of(UNDER_FOOT, UNDER_FOOT, delay_ms=100.0))
    verdict = next(i for i, m in enumerate(messages) if isinstance(m, Ack) and m.stage is Stage.COMPLETED)
    told = [message for message in messages[:verdict] if isinstance(message, Telemetry)][-1]
    assert told.reached == (0, 1)
    assert told.mode is Mode.DONE


def test_messages_are_heard_in_time_order_of_the_robots_steps() -> None:
    _, messages = flown(mission_of(UNDER_FOOT, OUT_OF_REACH, autonomy="waypoint", delay_ms=130.0))
    now = -1
    for message in messages:
        if isinstance(message, State):
            assert message.time_ns == message.step * TICK_NS
            now = message.time_ns
        elif isinstance(message, Telemetry | Ack | Command):
            assert now < message.received_ns <= now + TICK_NS or now == message.received_ns == 0
            assert message.issued_ns <= message.received_ns


def test_telemetry_comes_at_its_rate_and_whenever_the_mode_changes() -> None:
    mission = mission_of(OUT_OF_REACH | {"timeout_s": 4.0}, telemetry={"rate_hz": 2.0})
    _, messages = flown(mission)
    issued = [frame.issued_ns for frame in only(Telemetry, messages)]
    regular = set(range(0, 4000 * MS, 500 * MS))
    assert regular <= set(issued)
    assert set(issued) - regular == {4000 * MS}


@pytest.mark.parametrize("rate_hz", [0.7, 15.0, 45.0, 50.0])
def test_telemetry_keeps_any_rate(rate_hz: float) -> None:
    mission = mission_of(OUT_OF_REACH | {"timeout_s": 10.0}, telemetry={"rate_hz": rate_hz})
    _, messages = flown(mission)
    issued = [frame.issued_ns for frame in only(Telemetry, messages) if 0 < frame.issued_ns < 10_000 * MS]
    assert abs(len(issued) - 10.0 * rate_hz) <= 1


def test_a_checkpoint_stays_small_however_slow_the_link() -> None:
    mission = mission_of(OUT_OF_REACH | {"timeout_s": 60.0}, telemetry={"rate_hz": 50.0}, delay_ms=40_000.0)
    _, messages = flown(mission)
    links = [json.loads(checkpoint.link) for checkpoint in only(Checkpoint, messages)]
    assert max(len(json.dumps(link)) for link in links) < 5_000
    assert any(
        last - first > 1_000 for first, last in (link["down"]["frames"] for link in links if link["down"]["frames"][1:])
    )


def test_a_hold_lasts_on_the_robots_clock() -> None:
    _, messages = flown(mission_of(UNDER_FOOT | {"hold_s": 1.5}, UNDER_FOOT, delay_ms=500.0))
    (began,), (ended,) = times_ns(EventKind.HOLD_STARTED, messages), times_ns(EventKind.HOLD_COMPLETED, messages)
    assert ended - began == 1500 * MS
    holding = [a for a in only(Action, messages) if began <= a.time_ns < ended]
    assert {action.source for action in holding} == {"stance"}


def test_while_nobody_walks_the_stance_controller_has_the_motors_and_nothing_is_observed() -> None:
    _, messages = flown(mission_of(OUT_OF_REACH, delay_ms=200.0))
    robot = load_robot("ant")
    states = {state.step: state for state in only(State, messages)}
    observed = {observation.step for observation in only(Observation, messages)}
    for action in only(Action, messages):
        state = states[action.step]
        if action.source == "policy":
            assert action.commanded.tolist() == STILL.tolist()
        else:
            expected = stance_action(robot, state.qpos[np.newaxis], state.qvel[np.newaxis])[0]
            np.testing.assert_array_equal(action.commanded, expected)
        np.testing.assert_array_equal(action.applied, np.clip(action.commanded, -1, 1))
        assert (action.step in observed) == (action.source == "policy")
    assert {action.source for action in only(Action, messages)} == {"stance", "policy"}


def test_every_step_has_a_state_an_action_and_a_reward_and_the_last_state_stands_alone() -> None:
    _, messages = flown(mission_of(OUT_OF_REACH, delay_ms=100.0))
    states, actions, rewards = only(State, messages), only(Action, messages), only(Reward, messages)
    assert [state.step for state in states] == list(range(len(actions) + 1))
    assert [action.step for action in actions] == [reward.step for reward in rewards] == list(range(len(actions)))
    for reward in rewards:
        assert reward.time_ns == (reward.step + 1) * TICK_NS
        assert reward.total == pytest.approx(sum(value for _, value in reward.terms), abs=1e-12)


def test_progress_is_paid_while_walking_and_sums_to_the_ground_gained() -> None:
    goal = {"position_m": [3.0, 4.0], "timeout_s": 1.0}
    _, messages = flown(mission_of(goal, delay_ms=300.0), Scripted(0.4 * TUMBLE))
    states = {state.step: state for state in only(State, messages)}
    walked = {action.step for action in only(Action, messages) if action.source == "policy"}
    progress = {reward.step: dict(reward.terms)["progress"] for reward in only(Reward, messages)}
    assert all(value == 0.0 for step, value in progress.items() if step not in walked)
    far = [float(np.hypot(*(states[step].qpos[:2] - [3.0, 4.0]))) for step in (min(walked), max(walked) + 1)]
    assert sum(progress[step] for step in walked) * 0.02 == pytest.approx(far[0] - far[1], abs=1e-9)
    assert abs(far[0] - far[1]) > 0.01


def test_checkpoints_come_every_ten_seconds() -> None:
    _, messages = flown(mission_of(OUT_OF_REACH | {"timeout_s": 21.0}))
    assert [checkpoint.time_ns for checkpoint in only(Checkpoint, messages)] == [0, 10_000 * MS, 20_000 * MS]


@pytest.mark.parametrize("steps", [0, 1, 2, 30])
def test_a_flight_can_be_interrupted_before_any_step(steps: int) -> None:
    messages: list[Message] = []
    result = fly(
        mission_of(OUT_OF_REACH, delay_ms=100.0),
        Scripted(STILL),
        messages.append,
        interrupted=lambda: len(only(Action, messages)) == steps,
    )
    assert (result.outcome, result.sim_time_ns) == ("interrupted", steps * TICK_NS)
    assert len(only(Action, messages)) == steps
    assert only(State, messages)[-1].step == steps
    last = only(Event, messages)[-1]
    assert messages[-1] is last
    assert (last.kind, last.text) == (EventKind.MISSION_ENDED, "interrupted: 0 of 1 waypoints known to be reached")


def test_the_start_is_where_the_mission_says() -> None:
    mission = mission_of(OUT_OF_REACH, start={"position_m": [3.0, -2.0], "heading_deg": 90.0})
    _, messages = flown(mission)
    first = only(State, messages)[0]
    assert first.qpos[:2].tolist() == [3.0, -2.0]
    np.testing.assert_allclose(first.qpos[3:7], [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])


def test_another_seed_is_another_start_and_the_same_seed_the_same_flight() -> None:
    flights = [flown(mission_of(OUT_OF_REACH, seed=seed), Scripted(TUMBLE))[1] for seed in (1, 1, 2)]
    firsts, lasts = ([only(State, flight)[i].qpos.tobytes() for flight in flights] for i in (0, -1))
    assert firsts[0] == firsts[1] != firsts[2]
    assert lasts[0] == lasts[1] != lasts[2]
