"""The way as it is walked: from tolerance to tolerance."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from waypointctl.evaluation.walking_speed import walking_speed
from waypointctl.flight.fly import fly
from waypointctl.flight.forecast.route import route_findings
from waypointctl.flight.forecast.way import reached_at, walks_of
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.log.messages import Event, EventKind
from waypointctl.mission.files import parse_mission
from waypointctl.policy.bundle import load_policy

POLICY = Path(__file__).parents[3] / "policies" / "ant-waypoint"
HEAD = "name: n\npolicy: p\n"
FENCE = "onboard: {geofence: {keep_out: [{name: rock, center: [8.2 m, 3 m], radius: 1 m}]}}\n"


@pytest.mark.parametrize(
    ("acceptance", "start", "reached"),
    [
        ("radius", (0.0, 0.0), (7.0, 0.0)),
        ("box", (0.0, 0.0), (7.0, 0.0)),
        ("radius", (10.0, 9.0), (10.0, 3.0)),
        ("box", (0.0, -10.0), (7.0, -3.0)),  # by its corner
        ("radius", (0.0, -10.0), (10 - 3 / math.sqrt(2), -3 / math.sqrt(2))),
        ("box", (9.0, 1.0), (9.0, 1.0)),  # there already
        ("radius", (10.0, 0.0), (10.0, 0.0)),
    ],
)
def test_a_waypoint_is_reached_where_the_way_enters_its_tolerance(
    acceptance: str, start: tuple[float, float], reached: tuple[float, float]
) -> None:
    text = f"{HEAD}waypoints: [{{position: [10 m, 0 m], tolerance: 3 m, acceptance: {acceptance}}}]\n"
    (waypoint,) = planned_waypoints(parse_mission(text.encode(), "m.yaml"))
    assert reached_at(waypoint, start) == pytest.approx(reached)


def test_each_leg_begins_where_the_one_before_was_reached() -> None:
    text = f"{HEAD}waypoints: [{{position: [10 m, 0 m], tolerance: 3 m}}, [10, 10]]\n"
    first, second = walks_of(parse_mission(text.encode(), "m.yaml"), 2.0)
    assert first.way_m == pytest.approx(7)
    assert second.start_m == first.end_m == pytest.approx((7, 0))
    assert second.away_m == pytest.approx(math.hypot(3, 10))


@pytest.mark.parametrize(("tolerance", "crosses"), [(3, True), (0.5, False)])
def test_a_corner_that_is_cut_through_the_fence_is_told_and_flown(tolerance: float, crosses: bool) -> None:
    text = f"{HEAD}waypoints: [{{position: [10 m, 0 m], tolerance: {tolerance} m}}, [10, 10]]\n{FENCE}"
    mission = parse_mission(text.encode(), "m.yaml")
    told = [each.text for each in route_findings(mission, walking_speed(POLICY).mps) if each.kind == "fence"]
    breaches: list[Event] = []

    def sink(message: object) -> None:
        if isinstance(message, Event) and message.kind is EventKind.GEOFENCE_BREACHED:
            breaches.append(message)

    fly(mission, load_policy(POLICY), sink)
    assert (bool(told), bool(breaches)) == (crosses, crosses)
    if crosses:
        assert told == [
            "the leg to WP2 crosses keep-out rock where it begins at (7.0, 0.0): the robot turns to it before it is at "
            "WP1"
        ]
