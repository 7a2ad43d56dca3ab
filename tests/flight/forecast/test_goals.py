"""Steering as it is told, against flights: each band was measured on more flights than these (goals.py)."""

from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.evaluation.walking_speed import walking_speed
from waypointctl.flight.fly import fly
from waypointctl.flight.forecast.duration import expected
from waypointctl.flight.forecast.goals import goals_of, period_s, setting_out_s, whole
from waypointctl.flight.forecast.traffic import traffic_of
from waypointctl.flight.forecast.way import walks_of
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import load_policy
from waypointctl.units import seconds

POLICY = Path(__file__).parents[3] / "policies" / "ant-waypoint"
CORNER, CLIMB = "[[5, 0], [5, 5]]", "[[6, 3], [8, 9]]"


def steered(steering: str, lookahead_m: float, round_trip_s: float, waypoints: str) -> Mission:
    text = (
        f"name: n\npolicy: p\nautonomy: heading\nwaypoints: {waypoints}\nlink: {{delay: {round_trip_s / 2} s}}\n"
        f"operator: {{steering: {steering}, lookahead: {lookahead_m} m}}\ndefaults: {{timeout: 20 h}}\n"
    )
    return parse_mission(text.encode(), "m.yaml")


@pytest.mark.parametrize(
    ("steering", "lookahead_m", "round_trip_s", "waypoints", "band"),
    [
        ("move_and_wait", 1, 0.4, CLIMB, 0.1),
        ("move_and_wait", 2, 2.56, CLIMB, 0.1),
        ("move_and_wait", 2, 364, CORNER, 0.1),
        ("move_and_wait", 4, 364, CLIMB, 0.1),
        ("continuous", 1, 10, CLIMB, 0.15),
        ("continuous", 2, 2.56, CORNER, 0.15),
        ("continuous", 4, 10, CORNER, 0.15),
    ],
)
def test_a_flight_takes_as_long_as_is_told(
    steering: str, lookahead_m: float, round_trip_s: float, waypoints: str, band: float
) -> None:
    mission = steered(steering, lookahead_m, round_trip_s, waypoints)
    told = expected(mission, walking_speed(POLICY).mps, traffic_of(mission), "heading")
    flown = fly(mission, load_policy(POLICY), lambda _: None)
    assert flown.outcome == "success"
    assert told.time_s == pytest.approx(flown.known_ns / 1e9, rel=band)


def test_a_thought_makes_the_pose_behind_a_goal_older() -> None:
    mission = steered("continuous", 5, 0, CLIMB)
    thinking = mission.model_copy(update={"operator": mission.operator.model_copy(update={"think_s": 3.0})})
    speed_mps, traffic = walking_speed(POLICY).mps, traffic_of(thinking)
    quick, slow = (expected(each, speed_mps, traffic, "heading").time_s for each in (mission, thinking))
    assert quick is not None
    assert slow is not None
    assert slow > 1.2 * quick
    assert seconds(fly(thinking, load_policy(POLICY), lambda _: None).known_ns) == pytest.approx(slow, rel=0.15)


def test_each_goal_of_move_and_wait_costs_a_round_trip_and_setting_out() -> None:
    mission = steered("move_and_wait", 2, 364, CLIMB)
    found = expected(mission, 2.0, traffic_of(mission), "heading")
    way_s = sum(walk.way_m for walk in walks_of(mission, 2.0)) / 2
    assert found.exchanges == 10, "as flown"
    assert found.time_s == pytest.approx(way_s + 10 * (364 + setting_out_s(364)))


def test_a_waypoint_within_a_goal_s_distance_takes_one() -> None:
    (near, far) = walks_of(steered("move_and_wait", 5, 1, CORNER), 2.0)
    assert goals_of(near, steered("move_and_wait", 5, 1, CORNER)) == 1
    assert goals_of(far, steered("move_and_wait", 0.5, 1, CORNER)) > 5 / 0.5


def test_whole_counts_add_up() -> None:
    assert whole([3.33, 3.33]) == [3, 4]
    assert whole([0.2, 0.2, 7.5]) == [1, 1, 6]


@pytest.mark.parametrize(
    ("round_trip_s", "rate_hz", "period"), [(364, 1, 365), (10, 1, 11), (2.56, 0.2, 5), (10, 0.2, 15), (0, 1, 1)]
)
def test_goals_leave_at_whole_periods(round_trip_s: float, rate_hz: float, period: float) -> None:
    assert period_s(round_trip_s, rate_hz) == pytest.approx(period)
