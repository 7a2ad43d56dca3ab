"""Whatever a mission has to wait for, from a second to days, it goes on afterwards: under each autonomy."""

from __future__ import annotations

from typing import Any

import pytest

from tests.flight.flying import UNDER_FOOT, flown, mission_of
from waypointctl.units import NS_PER_S

DAY_S = 86_400.0
HELD = UNDER_FOOT | {"hold_s": 2.0}
LINK = {"delay_s": 0.2}


def window(gap_s: float) -> list[dict[str, float]]:
    """Return a contact of a second and, after a gap, one that is long enough."""
    return [{"from_s": 0.0, "to_s": 1.0}, {"from_s": 1.0 + gap_s, "to_s": 1.0 + gap_s + DAY_S}]


def waiting(kind: str, wait_s: float) -> dict[str, Any]:
    """Return what makes a mission through two waypoints wait so long."""
    hold = {"at_s": 1.0, "do": "hold"}
    changes: dict[str, dict[str, Any]] = {
        "hold": {"waypoints": [UNDER_FOOT | {"hold_s": wait_s}, UNDER_FOOT]},
        "think": {"operator": {"think_s": wait_s}},
        "late resume": {"schedule": [hold, {"at_s": 1.0 + wait_s, "do": "resume"}]},
        "kept resume": {"schedule": [hold, {"at_s": 1.5, "do": "resume", "not_before_s": 1.5 + wait_s}]},
        "contact up": {"link": {"up": LINK | {"windows": window(wait_s)}, "down": LINK}},
        "contact down": {"link": {"up": LINK, "down": LINK | {"windows": window(wait_s)}}},
        "delay": {"link": {"up": {"delay_s": wait_s}, "down": {"delay_s": wait_s}}},
    }
    return changes[kind]


CASES = [
    *((kind, wait_s) for kind in ("hold", "think") for wait_s in (1.0, DAY_S)),
    *((kind, wait_s) for kind in ("late resume", "kept resume") for wait_s in (1.0, 3 * DAY_S)),
    *((kind, 3 * DAY_S) for kind in ("contact up", "contact down", "delay")),
]
IN_ADVANCE = ("contact up", "think")  # nothing of a mission waits for these, whose plan has been sent before


@pytest.mark.parametrize(
    ("kind", "wait_s", "autonomy"),
    [
        (kind, wait_s, autonomy)
        for kind, wait_s in CASES
        for autonomy in ("mission", "waypoint", "short_range_goal")
        if autonomy != "mission" or kind not in IN_ADVANCE
    ],
)
def test_a_wait_is_stood_through(kind: str, wait_s: float, autonomy: str) -> None:
    content = {"waypoints": [HELD, HELD], "link": {"up": LINK, "down": LINK}} | waiting(kind, wait_s)
    waypoints = content.pop("waypoints")
    result, _ = flown(
        mission_of(*waypoints, autonomy=autonomy, telemetry={"rate_hz": 2.0, "beacon_s": 3600.0}, **content)
    )
    assert (result.outcome, result.waypoints_reached) == ("success", 2), result.reason
    assert result.sim_time_ns >= wait_s * NS_PER_S


@pytest.mark.parametrize("kind", ["hold", "late resume", "kept resume"])
def test_so_it_is_when_steering_continuously(kind: str) -> None:
    content = {"waypoints": [HELD, HELD], "link": {"up": LINK, "down": LINK}} | waiting(kind, DAY_S)
    waypoints = content.pop("waypoints")
    operator = {"steering": "continuous", "update_rate_hz": 10.0}
    telemetry = {"beacon_s": 3600.0}
    result, _ = flown(
        mission_of(*waypoints, autonomy="short_range_goal", operator=operator, telemetry=telemetry, **content)
    )
    assert (result.outcome, result.waypoints_reached) == ("success", 2), result.reason
    assert result.sim_time_ns >= DAY_S * NS_PER_S


@pytest.mark.parametrize("wait_s", [1.0, DAY_S])
def test_a_pilot_goes_on_after_a_hold(wait_s: float) -> None:
    held = UNDER_FOOT | {"hold_s": wait_s}
    result, _ = flown(mission_of(held, UNDER_FOOT, autonomy="joint", telemetry={"beacon_s": 3600.0}))
    assert (result.outcome, result.waypoints_reached) == ("success", 2), result.reason
    assert result.sim_time_ns >= wait_s * NS_PER_S


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "short_range_goal"])
@pytest.mark.parametrize("steering", ["move_and_wait", "continuous"])
def test_a_hold_that_nobody_ends_is_not_waited_for(autonomy: str, steering: str) -> None:
    content = {"operator": {"steering": steering}, "schedule": [{"at_s": 1.0, "do": "hold"}]}
    result, _ = flown(mission_of(HELD, HELD, autonomy=autonomy, delay_ms=200.0, **content))
    assert result.outcome == "failure"
    assert "no command followed" in result.reason
    assert result.sim_time_ns < 60 * NS_PER_S
