from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.flight.fly import fly
from waypointctl.flight.forecast.tolerance import SMALLEST_M, tolerance_findings
from waypointctl.mission.files import parse_mission
from waypointctl.policy.bundle import LoadedPolicy, load_policy

ROOT = Path(__file__).parents[3]
BASE = "name: n\npolicy: p\nwaypoints: [[5, 0], {position: [8 m, 4 m], tolerance: %g m}]\n"


@pytest.fixture(scope="module")
def policy() -> LoadedPolicy:
    return load_policy(ROOT / "policies" / "ant-waypoint")


def paths(text: str) -> list[tuple[str | int, ...]]:
    return [each.path for each in tolerance_findings(parse_mission(text.encode(), "m.yaml"))]


def test_what_is_finer_than_the_robot_walks_is_found() -> None:
    assert paths(BASE % 0.001 + "repeat: 3\n") == [("waypoints", 1, "tolerance_m")]
    assert paths(BASE % 0.5 + "schedule: [{at: 1 s, do: set_tolerance, tolerance: 1 mm}]\n") == [
        ("schedule", 0, "tolerance_m")
    ]
    (found,) = tolerance_findings(parse_mission((BASE % 0.001).encode(), "m.yaml"))
    assert found.text.startswith("WP2: 0.001 m is finer than a robot walks: ")


def test_what_the_robot_meets_is_not() -> None:
    assert paths(BASE % SMALLEST_M) == []
    assert paths(BASE % 0.001 + "onboard: {slip: 30 cm}\n") == []
    assert paths(BASE % 0.5 + "schedule: [{at: 1 s, do: hold}]\n") == []


@pytest.mark.parametrize("tolerance_m", [0.001, SMALLEST_M])
def test_the_bound_is_what_the_shipped_policy_meets(tolerance_m: float, policy: LoadedPolicy) -> None:
    text = BASE % tolerance_m
    result = fly(parse_mission(text.encode(), "m.yaml"), policy, lambda _: None)
    assert (result.outcome == "success") == (paths(text) == [])
