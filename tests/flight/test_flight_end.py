"""A flight goes on until all that was begun on board is over and the operator has heard of it."""

from __future__ import annotations

from typing import Any

import pytest

from tests.flight.flying import OUT_OF_REACH, TUMBLE, UNDER_FOOT, Scripted, flown, mission_of, only, times_ns
from waypointctl.log.messages import Event, EventKind, Mode, Telemetry
from waypointctl.units import NS_PER_S

DELAY_MS = 1500.0
AWAY = {"home": {"position_m": [300.0, 0.0], "timeout_s": 4.0}}  # a home that is not reached, and given up after 4 s
LOST = {"link_loss": {"after_s": 0.5, "do": "return_home"}}
FENCED = {"geofence": {"keep_out": [{"center_m": [0.0, 0.0], "radius_m": 5.0}], "do": "return_home"}}
SLOW = OUT_OF_REACH | {"timeout_s": 60.0}

RETURNS = [
    pytest.param((OUT_OF_REACH,), {"on_failure": "return_home"}, {}, "timeout", id="leg"),
    pytest.param((SLOW,), {}, LOST, "link lost", id="link loss"),
    pytest.param((SLOW,), {"operator": {"lookahead_m": 100.0}}, FENCED, "geofence", id="fence"),
]


@pytest.mark.parametrize(("autonomy", "reached"), [("mission", 0), ("waypoint", 0), ("short_range_goal", "all")])
@pytest.mark.parametrize(("waypoints", "changes", "onboard", "cause"), RETURNS)
def test_a_way_home_by_a_rule_is_waited_for_until_it_is_given_up(
    waypoints: tuple[Any, ...],
    changes: dict[str, Any],
    onboard: dict[str, Any],
    cause: str,
    autonomy: str,
    reached: Any,
) -> None:
    mission = mission_of(
        *waypoints,
        delay_ms=DELAY_MS,
        autonomy=autonomy,
        expect={"reached": reached},
        onboard=onboard | AWAY,
        **changes,
    )
    result, messages = flown(mission)
    (began,) = [event for event in only(Event, messages) if event.kind is EventKind.RETURN_STARTED]
    (ended,) = times_ns(EventKind.RETURN_FAILED, messages)
    assert began.text == f"returning home: {cause}"
    assert ended == began.time_ns + 4 * NS_PER_S
    assert result.sim_time_ns >= ended + DELAY_MS * 1e6, "the operator has heard of it"
    assert only(Telemetry, messages)[-1].mode is Mode.FAILED
    assert result.outcome == "failure"
    assert "way home given up: timeout" in result.reason or cause in result.reason


@pytest.mark.parametrize("autonomy", ["mission", "short_range_goal"])
@pytest.mark.parametrize(("waypoints", "changes", "onboard", "cause"), RETURNS)
@pytest.mark.parametrize(("reached", "outcome"), [(0, "success"), ("all", "failure")])
def test_at_home_a_mission_is_what_is_expected_of_it(
    waypoints: tuple[Any, ...],
    changes: dict[str, Any],
    onboard: dict[str, Any],
    cause: str,
    autonomy: str,
    reached: Any,
    outcome: str,
) -> None:
    home = {"home": {"position_m": [0.0, 0.0], "tolerance_m": 50.0}}
    mission = mission_of(
        *waypoints,
        delay_ms=DELAY_MS,
        autonomy=autonomy,
        expect={"reached": reached},
        onboard=onboard | home,
        **changes,
    )
    result, messages = flown(mission)
    (home_ns,) = times_ns(EventKind.HOME_REACHED, messages)
    assert result.sim_time_ns >= home_ns + DELAY_MS * 1e6
    assert only(Telemetry, messages)[-1].cause == f"at home: {cause}"
    assert (result.outcome, "the robot is at home" in result.reason) == (outcome, True)


def test_a_fall_on_the_way_home_is_no_success() -> None:
    far = OUT_OF_REACH | {"timeout_s": 0.1}
    home = {"home": {"position_m": [300.0, 0.0]}}
    mission = mission_of(far, delay_ms=500, on_failure="return_home", onboard=home, expect={"reached": 0})
    result, messages = flown(mission, Scripted(TUMBLE))
    assert times_ns(EventKind.FALL, messages)
    assert result.outcome == "failure"
    assert result.reason.startswith("fall: ")
    assert "the robot has fallen at" in result.reason


@pytest.mark.parametrize("acknowledged", [True, False])
def test_a_commanded_way_home_is_waited_for_acknowledged_or_not(acknowledged: bool) -> None:
    mission = mission_of(
        UNDER_FOOT,
        delay_ms=DELAY_MS,
        schedule=[{"at_s": 0.1, "do": "return_home", "not_before_s": 8.0}],
        onboard=AWAY,
        commands={"acknowledged": acknowledged},
    )
    result, messages = flown(mission)
    (ended,) = times_ns(EventKind.RETURN_FAILED, messages)
    assert ended == 12 * NS_PER_S
    assert result.sim_time_ns >= ended + DELAY_MS * 1e6


def test_a_hold_for_the_loss_of_the_link_is_waited_for_while_the_ground_still_sends() -> None:
    gap = {"windows": [{"from_s": 0.0, "to_s": 3.0}, {"from_s": 600.0, "to_s": 900.0}], "delay_s": 0.5}
    mission = mission_of(
        UNDER_FOOT | {"hold_s": 20.0},
        UNDER_FOOT,
        onboard={"link_loss": {"after_s": 5.0, "do": "hold"}},
        operator={"heartbeat_s": 2.0},
        link={"up": gap, "down": {"delay_s": 0.5}},
    )
    result, messages = flown(mission)
    assert times_ns(EventKind.LINK_RESTORED, messages)[0] >= 600 * NS_PER_S
    assert (result.outcome, result.waypoints_reached) == ("success", 2)


def test_what_the_loss_of_the_link_will_do_is_waited_for_where_nothing_keeps_it() -> None:
    mission = mission_of(
        OUT_OF_REACH,
        on_failure="hold",
        onboard={"link_loss": {"after_s": 400.0, "do": "return_home"}} | AWAY,
        delay_ms=DELAY_MS,
    )
    result, messages = flown(mission)
    assert times_ns(EventKind.RETURN_FAILED, messages)
    assert result.reason.startswith("link lost: ")


def test_so_it_is_where_the_operator_has_given_the_mission_up() -> None:
    mission = mission_of(
        OUT_OF_REACH,
        autonomy="short_range_goal",
        operator={"steering": "continuous", "update_rate_hz": 2.0},
        on_failure="hold",
        onboard={"link_loss": {"after_s": 20.0, "do": "return_home"}} | AWAY,
    )
    result, messages = flown(mission)
    assert result.reason.startswith("timeout: ")
    (ended,) = times_ns(EventKind.RETURN_FAILED, messages)
    assert result.known_ns < ended <= result.sim_time_ns


@pytest.mark.parametrize("loss", [0.5, 0.9])
def test_frames_that_are_lost_are_waited_for_until_one_arrives(loss: float) -> None:
    for seed in range(4):
        mission = mission_of(
            OUT_OF_REACH,
            on_failure="return_home",
            onboard={"home": {"position_m": [0.0, 0.0], "tolerance_m": 50.0}},
            link={"up": {"delay_s": 0.3}, "down": {"delay_s": 0.3, "loss": loss}},
            seed=seed,
        )
        result, messages = flown(mission)
        assert only(Telemetry, messages)[-1].cause == "at home: timeout"
        assert "the robot is at home" in result.reason


@pytest.mark.parametrize(
    "down", [{"loss": 1.0}, {"windows": [{"from_s": 0.0, "to_s": 1.2}]}, {"loss": {"p": 1.0, "r": 0.0}}]
)
def test_nobody_waits_for_frames_that_can_never_arrive(down: dict[str, Any]) -> None:
    mission = mission_of(OUT_OF_REACH, on_failure="return_home", onboard=AWAY, link={"up": {}, "down": down})
    result, messages = flown(mission)
    (ended,) = times_ns(EventKind.RETURN_FAILED, messages)
    assert ended <= result.sim_time_ns < ended + 60 * NS_PER_S
    assert result.outcome == "failure"


def test_steering_continuously_the_robot_stands_when_the_flight_ends_and_the_time_is_that_of_knowing() -> None:
    mission = mission_of(
        {"position_m": [0.0, 0.0], "tolerance_m": 0.5},
        autonomy="short_range_goal",
        operator={"steering": "continuous", "update_rate_hz": 5.0},
        delay_ms=DELAY_MS,
    )
    result, messages = flown(mission)
    assert result.outcome == "success"
    assert only(Telemetry, messages)[-1].mode is Mode.DONE
    assert result.known_ns < result.sim_time_ns
    assert f"in {result.known_ns / 1e9:.2f} s" in result.reason
