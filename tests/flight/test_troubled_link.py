"""What a link in trouble must not do to a flight."""

from __future__ import annotations

import pytest

from tests.flight.flying import OUT_OF_REACH, UNDER_FOOT, flown, mission_of, only, times_ns
from waypointctl.log.messages import Command, EventKind, Telemetry
from waypointctl.units import NS_PER_S

THREE = (UNDER_FOOT, UNDER_FOOT, UNDER_FOOT)


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "short_range_goal"])
def test_an_end_that_is_heard_of_twice_is_one_end(autonomy: str) -> None:
    link = {"up": {"delay_s": 0.2}, "down": {"delay_s": 0.2, "duplicate": 1.0}}
    result, messages = flown(mission_of(*THREE, autonomy=autonomy, operator={"think_s": 1.0}, link=link))
    assert (result.outcome, result.waypoints_reached) == ("success", 3)
    assert len(only(Command, messages)) == (1 if autonomy == "mission" else 3)


def test_a_command_that_is_kept_for_later_is_not_asked_after() -> None:
    schedule = [{"at_s": 0.5, "do": "set_timeout", "timeout_s": 60.0, "not_before_s": 30.0}]
    mission = mission_of(*THREE, autonomy="waypoint", operator={"think_s": 12.0}, schedule=schedule, delay_ms=200.0)
    result, messages = flown(mission)
    assert result.waypoints_reached == 3
    assert not result.reason.startswith("no acknowledgement")
    assert all(command.attempt == 1 for command in only(Command, messages))


def test_a_scheduled_command_that_is_never_answered_does_not_end_the_mission() -> None:
    windows = [{"from_s": 0.0, "to_s": 0.05}]
    schedule = [{"at_s": 0.06, "do": "set_tolerance", "tolerance_m": 1.0}]
    far = OUT_OF_REACH | {"timeout_s": 20.0}
    link = {"up": {"windows": windows, "delay_s": 0.1}, "down": {"delay_s": 0.1}}
    result, _ = flown(mission_of(far, schedule=schedule, link=link))
    assert result.reason.startswith("timeout: 0 of 1")


def test_heartbeats_neither_silence_the_beacon_nor_keep_a_flight_alive() -> None:
    mission = mission_of(
        OUT_OF_REACH,
        on_failure="hold",
        operator={"heartbeat_s": 1.0},
        telemetry={"rate_hz": 2.0, "beacon_s": 10.0},
        delay_ms=100.0,
        schedule=[{"at_s": 40.0, "do": "hold"}],
    )
    result, messages = flown(mission)
    assert result.outcome == "failure"
    assert result.sim_time_ns < 120 * NS_PER_S
    slept = times_ns(EventKind.REST_STARTED, messages)[0]
    assert any(frame.issued_ns > slept for frame in only(Telemetry, messages))


def test_the_longest_time_ends_a_flight_while_physics_sleeps() -> None:
    mission = mission_of(
        OUT_OF_REACH,
        on_failure="hold",
        operator={"heartbeat_s": 30.0},
        expect={"max_time_s": 25.0},
        schedule=[{"at_s": 60.0, "do": "resume"}],
    )
    result, _ = flown(mission)
    assert result.reason.startswith("the mission took longer than 25 s")
    assert result.sim_time_ns <= 25 * NS_PER_S + 2 * 20_000_000


def test_steered_continuously_a_robot_holds_as_long_as_it_is_to() -> None:
    held = UNDER_FOOT | {"hold_s": 6.0}
    mission = mission_of(
        held, UNDER_FOOT, autonomy="short_range_goal", operator={"steering": "continuous"}, delay_ms=300.0
    )
    result, messages = flown(mission)
    assert result.outcome == "success"
    (begun,), (ended,) = times_ns(EventKind.HOLD_STARTED, messages), times_ns(EventKind.HOLD_COMPLETED, messages)
    assert ended - begun == 6 * NS_PER_S


@pytest.mark.parametrize("operator", [{"steering": "move_and_wait"}, {"steering": "continuous"}])
def test_a_scheduled_hold_keeps_an_operator_who_steers_from_steering(operator: dict[str, str]) -> None:
    schedule = [{"at_s": 1.0, "do": "hold"}, {"at_s": 6.0, "do": "resume"}]
    far = OUT_OF_REACH | {"timeout_s": 8.0}
    _, messages = flown(
        mission_of(far, autonomy="short_range_goal", operator=operator, schedule=schedule, delay_ms=200.0)
    )
    held = [command for command in only(Command, messages) if 1.2 * NS_PER_S < command.received_ns < 6.2 * NS_PER_S]
    assert held == []
    after = [command for command in only(Command, messages) if command.received_ns > 6.2 * NS_PER_S]
    assert operator["steering"] == "move_and_wait" or after


def test_frames_that_were_overtaken_do_not_take_belief_back() -> None:
    down = {"delay_s": 2.0, "jitter_s": 2.0, "keep_order": False}
    result, messages = flown(
        mission_of(*THREE, autonomy="waypoint", telemetry={"rate_hz": 20.0}, link={"up": {}, "down": down}, seed=3)
    )
    frames = [frame.frame for frame in only(Telemetry, messages)]
    assert frames != sorted(frames), "some were overtaken"
    assert (result.outcome, result.waypoints_reached) == ("success", 3)
