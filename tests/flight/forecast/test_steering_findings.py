from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.evaluation.walking_speed import walking_speed
from waypointctl.flight.fly import fly
from waypointctl.flight.forecast.steering import steering_findings
from waypointctl.flight.forecast.traffic import traffic_of
from waypointctl.mission.files import parse_mission
from waypointctl.policy.bundle import load_policy
from waypointctl.units import NS_PER_S

POLICY = Path(__file__).parents[3] / "policies" / "ant-waypoint"
BASE = "name: n\npolicy: p\nautonomy: heading\n"
ONE = BASE + "waypoints: [[8, 6]]\n"  # 10 m
FAR = "link: {delay: 1 s}\n"


def found(text: str, speed_mps: float = 2.0) -> list[tuple[str, tuple[str | int, ...], str]]:
    mission = parse_mission(text.encode(), "m.yaml")
    return [(each.kind, each.path, each.text) for each in steering_findings(mission, speed_mps, traffic_of(mission))]


def test_goals_from_poses_that_are_old_are_found() -> None:
    near = ONE + FAR + "defaults: {timeout: 1 h}\noperator: {steering: continuous, lookahead: %s m}\n"
    assert found(near % 1) == [
        (
            "steering",
            ("operator", "lookahead_m"),
            "goals lie 1 m ahead of a pose that is 3.00 s old when the next comes, and the robot walks 6.0 m in that "
            "time: it stands and waits between goals, and takes 7.3 times as long",
        )
    ]
    assert found(near % 5.4) == []  # 6 m against the 4.05 m to where it counts as reached
    assert [kind for kind, _, _ in found(near % 4.4)] == ["steering"]  # against 3.9 m: half as long again


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "joint"])
def test_nobody_else_s_clock_counts_for_a_leg(autonomy: str) -> None:
    assert found(ONE.replace("heading", autonomy) + "link: {delay: 1 h}\n") == []


@pytest.mark.parametrize("steering", ["move_and_wait", "continuous"])
def test_what_the_robot_stands_between_goals_is_no_time_of_the_leg(steering: str) -> None:
    text = (
        "name: n\npolicy: p\nautonomy: heading\nwaypoints: [[6, 2]]\nlink: {delay: 5 s}\n"
        f"operator: {{steering: {steering}}}\ndefaults: {{timeout: 12 s}}\n"
    )
    flown = fly(parse_mission(text.encode(), "m.yaml"), load_policy(POLICY), lambda _: None)
    assert (flown.outcome, flown.known_ns > 30 * NS_PER_S) == ("success", True)
    assert [kind for kind, _, _ in found(text, walking_speed(POLICY).mps) if kind == "timeout"] == []
