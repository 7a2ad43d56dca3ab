"""A return home for later, commanded while the operator still leads the robot from waypoint to waypoint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.flight.flying import flown, mission_of, only, times_ns
from waypointctl.log.messages import Action, Command, CommandKind, EventKind
from waypointctl.policy.bundle import LoadedPolicy, load_policy

REPOSITORY = Path(__file__).parents[2]
PLACES = ({"position_m": [3.0, 0.0]}, {"position_m": [6.0, 0.0]}, {"position_m": [9.0, 0.0]})
HOME_S = 2.0
AUTONOMIES: tuple[dict[str, Any], ...] = (
    {"autonomy": "joint"},
    {"autonomy": "waypoint", "delay_ms": 300.0},
    {"autonomy": "short_range_goal", "delay_ms": 300.0, "operator": {"steering": "move_and_wait"}},
    {"autonomy": "short_range_goal", "delay_ms": 300.0, "operator": {"steering": "continuous", "update_rate_hz": 5.0}},
)


@pytest.fixture(scope="module")
def policy() -> LoadedPolicy:
    return load_policy(REPOSITORY / "policies" / "ant-waypoint")


@pytest.mark.parametrize("led", AUTONOMIES)
def test_nothing_calls_the_robot_back_from_a_return_home_for_later(policy: LoadedPolicy, led: dict[str, Any]) -> None:
    home = {"at_s": 0.1, "do": "return_home", "not_before_s": HOME_S}
    result, messages = flown(
        mission_of(*PLACES, schedule=[home], onboard={"home": {"tolerance_m": 1.0}}, **led), policy
    )
    (started_ns,) = times_ns(EventKind.RETURN_STARTED, messages)
    (reached_ns,) = times_ns(EventKind.HOME_REACHED, messages)
    assert started_ns == HOME_S * 1e9
    goals = [it for it in only(Command, messages) if it.kind is CommandKind.GO_TO]
    assert all(it.received_ns <= started_ns for it in goals)
    assert not [it for it in only(Action, messages) if it.source == "ground" and it.time_ns >= started_ns]
    assert (result.outcome, "the robot is at home" in result.reason) == ("failure", True), result.reason
    assert reached_ns > started_ns


@pytest.mark.parametrize("led", AUTONOMIES)
def test_the_operator_leads_on_where_the_return_home_is_cancelled(policy: LoadedPolicy, led: dict[str, Any]) -> None:
    home = {"at_s": 0.1, "do": "return_home", "not_before_s": HOME_S}
    number = 1 if led["autonomy"] == "joint" else 2
    cancel = {"at_s": 0.15, "do": "cancel", "command": number}
    result, messages = flown(mission_of(*PLACES[:2], schedule=[home, cancel], **led), policy)
    assert (result.outcome, result.waypoints_reached) == ("success", 2), result.reason
    assert not times_ns(EventKind.RETURN_STARTED, messages)
