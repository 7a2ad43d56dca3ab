"""Findings on the rules on board: a way home, and a stuck rule, that the robot cannot meet."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from waypointctl.flight.checks.finding import Finding
from waypointctl.flight.executive.fence import Point, crosses
from waypointctl.flight.executive.rules import Rules, rules_of
from waypointctl.mission.mission import Mission
from waypointctl.units import seconds

SETTING_OUT_S: Final = 0.4  # until a standing ant is under way: move and wait in docs/delay.md, less way and round trip


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
