"""What may go wrong on the way: the fence, waypoints that are one, legs that have too little time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from waypointctl.flight.executive.fence import Fence, Point, crosses
from waypointctl.flight.executive.rules import rules_of
from waypointctl.flight.forecast.finding import NOT_COMPLETED, Finding
from waypointctl.flight.forecast.rejection import rejection
from waypointctl.flight.forecast.way import reached_at, walks_of
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.mission.mission import Leg, Mission


def route_findings(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield what may go wrong between the start and the last waypoint."""
    yield from _fence(mission, speed_mps)
    yield from _nearness(mission)
    yield from _time(mission, speed_mps)


def _fence(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    fence = rules_of(mission).fence
    start = mission.start.position_m
    if breach := fence.breach(*start):
        yield Finding("fence", ("start",), f"the start {breach}", consequence="")
    turns = {walk.waypoint.index: walk.start_m for walk in walks_of(mission, speed_mps)}
    before_name, before = "the start", start
    for leg, waypoint in zip(mission.legs(), planned_waypoints(mission), strict=True):
        place = (leg.x_m, leg.y_m)
        turn = turns.get(leg.index, before)
        if breach := fence.breach(*place):
            yield Finding("fence", ("waypoints", leg.at), f"{leg.name} {breach}: {rejection(mission)}", consequence="")
        elif breach := _breach_on_way(fence, before, place):
            text = f"the leg to {leg.name} {crosses(breach)}"
            yield Finding("fence", ("waypoints", leg.at), text, NOT_COMPLETED)
        elif breach := _breach_on_way(fence, turn, reached_at(waypoint, turn)):
            text = (
                f"the leg to {leg.name} {crosses(breach)} where it begins at ({turn[0]:.1f}, {turn[1]:.1f}): the robot "
                f"turns to it before it is at {before_name}"
            )
            yield Finding("fence", ("waypoints", leg.at), text, NOT_COMPLETED)
        before_name, before = leg.name, place
    if (home := mission.onboard.home.position_m) is not None and (breach := fence.breach(*home)):
        yield Finding("fence", ("onboard", "home", "position_m"), f"home {breach}")


def _breach_on_way(fence: Fence, start: Point, end: Point) -> str:
    """Return how the straight way from a place that the fence allows breaks it; empty if it does not."""
    return "" if fence.breach(*start) else fence.breach_between(start, end)


def _nearness(mission: Mission) -> Iterator[Finding]:
    legs = mission.legs()
    first = legs[0]
    if _reaches(first, mission.start.position_m):
        distance_m = math.dist(mission.start.position_m, (first.x_m, first.y_m))
        text = f"{first.name} is {distance_m:.2f} m from the start, within its tolerance: reached at once"
        yield Finding("near", ("waypoints", first.at), text)
    for before, leg in pairwise(legs):
        distance_m = math.dist((before.x_m, before.y_m), (leg.x_m, leg.y_m))
        if distance_m < before.tolerance_m + leg.tolerance_m:
            text = (
                f"{leg.name} is {distance_m:.2f} m from {before.name}, and their tolerances are {leg.tolerance_m:g} m "
                f"and {before.tolerance_m:g} m: one place can be both"
            )
            yield Finding("near", ("waypoints", leg.at), text)


def _reaches(leg: Leg, place: tuple[float, float]) -> bool:
    dx_m, dy_m = abs(leg.x_m - place[0]), abs(leg.y_m - place[1])
    if leg.acceptance == "box":
        return dx_m < leg.tolerance_m and dy_m < leg.tolerance_m
    return math.hypot(dx_m, dy_m) < leg.tolerance_m


def _time(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield the legs whose time is out before they can be walked."""
    tries = 1 + mission.failure_rule.retry
    legs = mission.legs()
    for walk in walks_of(mission, speed_mps):
        leg = legs[walk.waypoint.index]
        needed_s = walk.way_m / speed_mps
        if needed_s > leg.timeout_s:
            given = f"{leg.timeout_s:g} s" + (f", with {tries} attempts" if tries > 1 else "")
            text = f"the leg to {leg.name} takes about {needed_s:.1f} s; its timeout is {given}"
            yield Finding("timeout", ("waypoints", leg.at, "timeout_s"), text, NOT_COMPLETED)
