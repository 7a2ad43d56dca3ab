"""Findings on the ways of the robot: fence, distances, timeouts, tolerances, and rules on board that it cannot meet."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

from waypointctl.flight.checks import Finding
from waypointctl.flight.executive.rules import OBSERVATION_NS, Fence, Point, Rules, crosses, fence_of, rules_of
from waypointctl.mission.mission import Leg, Mission
from waypointctl.units import seconds

# The evaluations go down to 0.2 m. Within 0.05 m the shipped policy reaches a waypoint in the same time; within 0.02 m
# it circles around it, 1.6 times as long, within 0.001 m until its time is out (six flights each).
SMALLEST_M: Final = 0.05

_REJECTED: Final = {
    "mission": "the robot will reject the whole plan",
    "waypoint": "the robot will reject it, and the mission ends there",
    "short_range_goal": "the robot will reject the first goal outside, and the mission ends there",
    "joint": "the robot will stop at the fence",
}

SETTING_OUT_S: Final = 0.4  # until a standing ant is under way: move and wait in docs/delay.md, less way and round trip


def route_findings(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield what may go wrong between the start and the last waypoint."""
    yield from _fence(mission)
    yield from _nearness(mission)
    yield from _timeouts(mission, speed_mps)
    yield from _tolerances(mission)


def driving_time_s(mission: Mission, speed_mps: float) -> float:
    """Return the least time for the robot's legs and holds, its legs' timeouts considered [s]."""
    tries = 1 + mission.failure_rule.retry
    legs_s = (min(way_m / speed_mps, leg.timeout_s * tries) for leg, _, way_m in _ways(mission))
    stands_s = (leg.hold_s + leg.observe * seconds(OBSERVATION_NS) for leg in mission.legs())
    return sum(legs_s) + sum(stands_s)


def _ways(mission: Mission) -> Iterator[tuple[Leg, Point, float]]:
    """Yield each leg, where the robot turns to it, and how far it is from there to where the waypoint is reached [m].

    A waypoint is reached where the straight way enters its tolerance; there the robot turns to the next.
    """
    place = mission.start.position_m
    for leg in mission.legs():
        dx_m, dy_m = leg.x_m - place[0], leg.y_m - place[1]
        away_m = math.hypot(dx_m, dy_m)
        box = leg.acceptance == "box" and away_m > 0
        within_m = leg.tolerance_m * (away_m / max(abs(dx_m), abs(dy_m)) if box else 1.0)
        way_m = max(away_m - within_m, 0.0)
        yield leg, place, way_m
        if way_m:
            place = (place[0] + dx_m * way_m / away_m, place[1] + dy_m * way_m / away_m)


def _fence(mission: Mission) -> Iterator[Finding]:
    fence = fence_of(mission)
    if not fence.keep_in and not fence.keep_out:
        return
    if breach := fence.breach(*mission.start.position_m):
        yield Finding("fence", ("start",), f"the start {breach}")
    before, before_name, checked = mission.start.position_m, "the start", set()
    for leg, turn, _ in _ways(mission):
        place, path = (leg.x_m, leg.y_m), ("waypoints", leg.at)
        if (before, turn, place) in checked:  # in an earlier round
            continue
        checked.add((before, turn, place))
        if breach := fence.breach(*place):
            yield Finding("fence", path, f"{leg.name} {breach}: {_REJECTED[mission.autonomy]}", prevents=True)
        elif breach := _breach_on_way(fence, before, place):
            yield Finding("fence", path, f"the straight leg to {leg.name} {crosses(breach)}")
        elif breach := _breach_on_way(fence, turn, place):
            text = (
                f"the leg to {leg.name} {crosses(breach)}: it begins at ({turn[0]:.1f}, {turn[1]:.1f}), where "
                f"{before_name} counts as reached"
            )
            yield Finding("fence", path, text)
        before, before_name = place, leg.name
    if (home := mission.onboard.home.position_m) is not None and (breach := fence.breach(*home)):
        yield Finding("fence", ("onboard", "home", "position_m"), f"home {breach}")


def _breach_on_way(fence: Fence, start: Point, end: Point) -> str:
    """Return how the straight way from a place that the fence allows breaks it; empty if it does not."""
    return "" if fence.breach(*start) else fence.breach_between(start, end)


def _nearness(mission: Mission) -> Iterator[Finding]:
    """Yield waypoints that the robot is at when it sets out for them."""
    legs = mission.legs()
    first, start = legs[0], mission.start.position_m
    dx_m, dy_m = abs(first.x_m - start[0]), abs(first.y_m - start[1])
    away_m = max(dx_m, dy_m) if first.acceptance == "box" else math.hypot(dx_m, dy_m)
    if away_m < first.tolerance_m:
        text = f"{first.name} is {math.hypot(dx_m, dy_m):.2f} m from the start, within its tolerance: reached at once"
        yield Finding("near", ("waypoints", first.at), text)
    for before, leg in pairwise(legs):
        distance_m = math.dist((before.x_m, before.y_m), (leg.x_m, leg.y_m))
        if distance_m < before.tolerance_m + leg.tolerance_m:
            text = (
                f"{leg.name} is {distance_m:.2f} m from {before.name}, and their tolerances are {leg.tolerance_m:g} m "
                f"and {before.tolerance_m:g} m: one place can satisfy both"
            )
            yield Finding("near", ("waypoints", leg.at), text)


def _timeouts(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield legs whose timeout is shorter than the drive."""
    tries = 1 + mission.failure_rule.retry
    for leg, _, way_m in _ways(mission):
        needed_s = way_m / speed_mps
        if needed_s > leg.timeout_s:
            given = f"{leg.timeout_s:g} s" + (f", with {tries} attempts" if tries > 1 else "")
            text = f"the leg to {leg.name} takes about {needed_s:.1f} s; its timeout is {given}"
            yield Finding("timeout", ("waypoints", leg.at, "timeout_s"), text)


def _tolerances(mission: Mission) -> Iterator[Finding]:
    """Yield tolerances that are finer than the policy reaches, where a near miss does not count."""
    if mission.onboard.stopped_tolerance_m >= SMALLEST_M:
        return
    given = [(("waypoints", leg.at, "tolerance_m"), leg.name, leg.tolerance_m) for leg in mission.legs()]
    given += [
        (("schedule", place, "tolerance_m"), command.do, command.tolerance_m)
        for place, command in enumerate(mission.schedule)
        if command.tolerance_m is not None
    ]
    for path, what, tolerance_m in given:
        if tolerance_m < SMALLEST_M:
            text = (
                f"{what}: with a tolerance of {tolerance_m:g} m the robot may circle the place until its timeout; "
                f"give {SMALLEST_M:g} m or more, or set onboard.stopped_tolerance so that a near miss counts"
            )
            yield Finding("tolerance", path, text)


def rule_findings(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield rules on board that cannot be met."""
    yield from _way_home(mission, speed_mps)
    yield from _stuck(mission, speed_mps)


def _way_home(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield a way home that is not completed, where something may send the robot home.

    A rule may do that anywhere: the farthest place counts, and the first from which the fence is in the way. A
    scheduled command does it once, at a place that is not known before: the nearest counts.
    """
    rules = rules_of(mission)
    home = (rules.home.x_m, rules.home.y_m)
    fence = mission.onboard.geofence
    by_rule = (
        rules.then == "return_home"
        or (rules.on_breach == "return_home" and bool(fence.keep_in + fence.keep_out))
        or (rules.link_loss_ns > 0 and rules.on_link_loss == "return_home")
    )
    if not by_rule and not any(command.do == "return_home" for command in mission.schedule):
        return
    places = [("the start", mission.start.position_m), *((leg.name, (leg.x_m, leg.y_m)) for leg in mission.legs())]
    yield from _through_the_fence(rules, places, by_rule=by_rule)
    ways = [(math.dist(place, home), name) for name, place in places]
    way_m, name = max(ways) if by_rule else min(ways)
    timeout_s = seconds(rules.home.timeout_ns)
    needed_s = (way_m - rules.home.tolerance_m) / speed_mps
    if needed_s > timeout_s:
        text = f"the way home from {name} takes about {needed_s:.0f} s; its timeout is {timeout_s:g} s"
        yield Finding("timeout", ("onboard", "home", "timeout_s"), text)


def _through_the_fence(rules: Rules, places: Sequence[tuple[str, Point]], *, by_rule: bool) -> Iterator[Finding]:
    """Yield a straight way home that breaks the fence: from any of the places, or, not by a rule, from all of them."""
    home = (rules.home.x_m, rules.home.y_m)
    if rules.fence.breach(*home):
        return  # reported for home itself
    inside = {place: name for name, place in reversed(places) if not rules.fence.breach(*place)}
    breaches = [(name, rules.fence.breach_between(place, home)) for place, name in reversed(inside.items())]
    name, breach = next(((name, breach) for name, breach in breaches if breach), ("", ""))
    if breach and (by_rule or all(breach for _, breach in breaches)):
        follows = "the robot continues to home" if rules.on_breach == "return_home" else "it will not be completed"
        text = f"the straight way home from {name} {crosses(breach)}: {follows}"
        yield Finding("fence", ("onboard", "geofence"), text)


def _stuck(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield a rule by which a robot that moves at the policy's speed counts as stuck."""
    stuck = mission.onboard.stuck
    if stuck is None or mission.autonomy == "joint":
        return
    needed_s = SETTING_OUT_S + stuck.within_m / speed_mps
    if needed_s > stuck.for_s:
        text = (
            f"{stuck.within_m:g} m in {stuck.for_s:g} s: a robot that starts from rest needs "
            f"about {needed_s:.1f} s for that, at {speed_mps:.2f} m/s, and counts as stuck where it starts"
        )
        yield Finding("stuck", ("onboard", "stuck"), text)
