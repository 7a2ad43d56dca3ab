from __future__ import annotations

from itertools import pairwise

import pytest

from tests.flight.flying import OUT_OF_REACH, UNDER_FOOT, flown, mission_of, only, times_ns
from waypointctl.flight.vehicle import REST_AFTER_NS
from waypointctl.log.messages import Event, EventKind, State, Telemetry
from waypointctl.units import NS_PER_S


@pytest.mark.slow
def test_a_delay_of_days_costs_no_more_physics_than_one_of_a_minute() -> None:
    steps = []
    for delay_s in (60.0, 5 * 86_400.0):
        result, messages = flown(mission_of(UNDER_FOOT, UNDER_FOOT, delay_ms=delay_s * 1000, autonomy="waypoint"))
        assert result.outcome == "success"
        assert result.sim_time_ns > 4 * delay_s * NS_PER_S
        steps.append(len(only(State, messages)))
    assert steps[0] == steps[1]


def test_physics_sleeps_only_where_nothing_moves_and_wakes_with_what_arrives() -> None:
    _, messages = flown(mission_of(UNDER_FOOT, delay_ms=60_000.0))
    (slept, *_), (woke, *_) = times_ns(EventKind.REST_STARTED, messages), times_ns(EventKind.REST_ENDED, messages)
    assert slept >= REST_AFTER_NS
    assert woke == 60 * NS_PER_S == times_ns(EventKind.COMMAND_RECEIVED, messages)[0]
    kinds = (EventKind.REST_STARTED, EventKind.REST_ENDED)
    texts = [event.text for event in only(Event, messages) if event.kind in kinds]
    assert texts[:2] == ["robot at rest: simulation skips to the next event", "simulation continues"]
    states = {state.time_ns: state for state in only(State, messages)}
    assert not [time for time in states if slept < time < woke], "no state is made up"
    before, after = states[slept - 20_000_000], states[woke]
    assert after.step == before.step + 1, "steps count physics"
    assert abs(before.qvel).max() < 1e-2


def test_a_robot_at_rest_sends_beacons_and_goes_back_to_its_rate() -> None:
    mission = mission_of(
        OUT_OF_REACH | {"timeout_s": 3.0}, telemetry={"rate_hz": 2.0, "beacon_s": 30.0}, delay_ms=100_000.0
    )
    _, messages = flown(mission)
    issued = sorted(frame.issued_ns for frame in only(Telemetry, messages))
    slept, woke = times_ns(EventKind.REST_STARTED, messages)[0], times_ns(EventKind.REST_ENDED, messages)[0]
    asleep = [time for time in issued if slept < time < woke]
    assert 2 <= len(asleep) <= 3
    assert all(30 * NS_PER_S <= b - a <= 31 * NS_PER_S for a, b in pairwise(asleep))
    walking = [time for time in issued if woke < time < woke + 3 * NS_PER_S]
    assert len(walking) >= 5


def test_a_short_wait_is_no_rest() -> None:
    _, messages = flown(mission_of(UNDER_FOOT, UNDER_FOOT, delay_ms=4_000.0, autonomy="waypoint"))
    assert times_ns(EventKind.REST_STARTED, messages) == []
