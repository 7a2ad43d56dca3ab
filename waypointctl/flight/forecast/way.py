"""The way that a robot is expected to walk: from where one waypoint counts as reached to where the next one does."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

from waypointctl.flight.executive.judgement import OBSERVATION_NS, OBSERVE
from waypointctl.flight.forecast.tolerance import is_missed
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.log.messages import PlannedWaypoint
from waypointctl.mission.mission import Mission
from waypointctl.units import seconds

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Walk:
    """A leg as it is expected.

    Attributes:
        waypoint: that it leads to.
        start_m: where it begins, (x, y).
        end_m: where it ends: where the waypoint counts as reached, or its time is out.
        duration_s: from setting out to having held and observed there; None where its time is out before it is reached.
    """

    waypoint: PlannedWaypoint
    start_m: Point
    end_m: Point
    duration_s: float | None

    @property
    def way_m(self) -> float:
        """How far it is to where the waypoint counts as reached."""
        return math.dist(self.start_m, reached_at(self.waypoint, self.start_m))

    @property
    def away_m(self) -> float:
        """How far it is to the waypoint itself."""
        return math.dist(self.start_m, (self.waypoint.x_m, self.waypoint.y_m))


def walks_of(mission: Mission, speed_mps: float) -> tuple[Walk, ...]:
    """Return the legs that the robot sets out on, from where it is expected to be.

    One whose time is too short, or whose tolerance is too small, is given up; unless the mission goes on then, it is
    the last.
    """
    place, rule = mission.start.position_m, mission.failure_rule
    walks = []
    for waypoint in planned_waypoints(mission):
        end = reached_at(waypoint, place)
        way_m = math.dist(place, end)
        walked_m = seconds(waypoint.timeout_ns) * (1 + rule.retry) * speed_mps
        if is_missed(mission, waypoint.tolerance_m):
            walked_m = min(walked_m, way_m)
        elif way_m <= walked_m:
            walks.append(Walk(waypoint, place, end, way_m / speed_mps + stands_s(waypoint)))
            place = end
            continue
        given_up = _between(place, end, walked_m / way_m) if way_m else end
        walks.append(Walk(waypoint, place, given_up, None))
        if rule.then != "skip":
            break
        place = given_up
    return tuple(walks)


def reached_at(waypoint: PlannedWaypoint, start: Point) -> Point:
    """Return where a waypoint counts as reached on the straight way to it; `start` where it does so at once."""
    center = (waypoint.x_m, waypoint.y_m)
    away_m = math.dist(start, center)
    if away_m == 0:
        return start
    towards = ((center[0] - start[0]) / away_m, (center[1] - start[1]) / away_m)
    return _between(start, center, max(1 - within_m(waypoint, towards) / away_m, 0.0))


def within_m(waypoint: PlannedWaypoint, towards: Point) -> float:
    """Return how far from its centre a waypoint counts as reached by who walks towards it: a unit vector."""
    if waypoint.acceptance != "box":
        return waypoint.tolerance_m
    return waypoint.tolerance_m / max(abs(towards[0]), abs(towards[1]))


def stands_s(waypoint: PlannedWaypoint) -> float:
    """Return how long the robot stands at a waypoint for its hold and its task [s]."""
    return seconds(waypoint.hold_ns + (OBSERVATION_NS if waypoint.task == OBSERVE else 0))


def _between(start: Point, end: Point, at: float) -> Point:
    return start[0] + at * (end[0] - start[0]), start[1] + at * (end[1] - start[1])
