from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.evaluation.walking_speed import walking_speed
from waypointctl.mission.files import parse_mission
from waypointctl.ops.fly import fly
from waypointctl.ops.forecast.goals import setting_out_s
from waypointctl.ops.forecast.steering import steering_findings
from waypointctl.ops.forecast.traffic import traffic_of
from waypointctl.policy.bundle import load_policy

POLICY = Path(__file__).parents[3] / "policies" / "ant-waypoint"
BASE = "name: n\npolicy: p\nautonomy: heading\n"
ONE = BASE + "waypoints: [[8, 6]]\n"  # 10 m
FAR = "link: {delay: 1 s}\n"


def found(text: str, speed_mps: float = 2.0) -> list[tuple[str, tuple[str | int, ...], str]]:
    mission = parse_mission(text.encode(), "m.yaml")
    return [(each.kind, each.path, each.text) for each in steering_findings(mission, speed_mps, traffic_of(mission))]


def test_a_leg_needs_time_for_its_goals_but_for_the_last() -> None:
    # 14 goals of 1 m, each reached in a box of 0.25 m round it, nine metres and a third in all: before the last one are
    # 13 walks, and between them 12 round trips, 12 thoughts, 13/14 of the way, and setting out
    needed_s = 12 * 2 + 12 * 1 + (10 - 0.5 / 0.8) / 2 * 13 / 14 + 13 * setting_out_s(3)
    text = ONE + FAR + "operator: {think: 1 s}\n"
    assert found(text) == [
        (
            "timeout",
            ("waypoints", 0, "timeout_s"),
            f"WP1 takes 14 short-range goals: the robot is on its way for {needed_s:.1f} s until the last but one is "
            "reached, waiting included, and the leg has 30 s; give it more, or a longer operator.carrot",
        )
    ]
    assert found(text + f"defaults: {{timeout: {needed_s + 0.1} s}}\n") == []
    assert len(found(text + f"defaults: {{timeout: {needed_s - 0.1} s}}\n")) == 1
    assert found(text.replace("think: 1 s", "carrot: 4 m")) == []


def test_each_leg_counts_from_the_end_of_the_one_before() -> None:
    legs = "waypoints: [[4, 3], [4, 4], {position: [4 m, 14 m], timeout: 20 s}]\n"
    places = [path for _, path, _ in found(BASE + legs + FAR)]
    assert places == [("waypoints", 2, "timeout_s")]


def test_a_leg_waits_for_contacts_too() -> None:
    windows = "link: {up: {windows: [{from: 0 s, to: 1 s}], windows_every: 15 s}}\n"
    assert found(ONE) == []
    ((_, path, _),) = found(ONE + windows)
    assert path == ("waypoints", 0, "timeout_s")


def test_goals_from_poses_that_are_old_are_found() -> None:
    near = ONE + FAR + "defaults: {timeout: 1 h}\noperator: {steering: continuous, carrot: %s m}\n"
    assert found(near % 1) == [
        (
            "steering",
            ("operator", "carrot_m"),
            "goals lie 1 m ahead of a pose that is 3.00 s old when the next comes, and the robot walks 6.0 m in that "
            "time: it stands and waits between goals, and takes 7.3 times as long",
        )
    ]
    assert found(near % 5.4) == []  # 6 m against the 4.05 m to where it counts as reached
    assert [kind for kind, _, _ in found(near % 4.4)] == ["steering"]  # against 3.9 m: half as long again


def test_a_leg_takes_longer_for_old_poses() -> None:
    text = ONE + FAR + "operator: {steering: continuous, carrot: 1 m}\n"
    _, (kind, path, said) = found(text)
    assert (kind, path) == ("timeout", ("waypoints", 0, "timeout_s"))
    assert said == "WP1 takes 34.0 s steered from poses that old, and the leg has 30 s"


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "joint"])
def test_nobody_else_s_clock_counts_for_a_leg(autonomy: str) -> None:
    assert found(ONE.replace("heading", autonomy) + "link: {delay: 1 h}\n") == []


@pytest.mark.parametrize("steering", ["move_and_wait", "continuous"])
def test_what_is_told_is_what_happens(steering: str) -> None:
    text = (
        f"name: n\npolicy: p\nautonomy: heading\nwaypoints: [[6, 2]]\nlink: {{delay: 1 s}}\n"
        f"operator: {{steering: {steering}}}\ndefaults: {{timeout: "
    )
    policy, speed_mps = load_policy(POLICY), walking_speed(POLICY).mps
    for timeout, is_enough in (("12 s", False), ("60 s", True)):
        whole = f"{text}{timeout}}}\n"
        told = [kind for kind, _, _ in found(whole, speed_mps)]
        flown = fly(parse_mission(whole.encode(), "m.yaml"), policy, lambda _: None)
        assert (("timeout" not in told), flown.outcome == "success") == (is_enough, is_enough)
