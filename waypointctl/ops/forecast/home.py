"""A way home that takes longer than it may."""

from __future__ import annotations

import math
from collections.abc import Iterator

from waypointctl.mission.mission import Mission
from waypointctl.ops.executive.rules import rules_of
from waypointctl.ops.forecast.finding import Finding
from waypointctl.units import seconds


def home_findings(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield a way home whose time is out before it is walked, where something may send the robot home.

    A rule may do that anywhere: the farthest place counts. A scheduled command does it at one time: the nearest counts,
    for the rest is for the schedule to say.
    """
    rules = rules_of(mission)
    home = (rules.home.x_m, rules.home.y_m)
    places = [("the start", mission.start.position_m), *((leg.name, (leg.x_m, leg.y_m)) for leg in mission.legs())]
    ways = [(math.dist(place, home), name) for name, place in places]
    fence = mission.onboard.geofence
    by_rule = rules.then == "return_home" or (rules.on_breach == "return_home" and bool(fence.keep_in + fence.keep_out))
    by_rule = by_rule or (rules.link_loss_ns > 0 and rules.on_link_loss == "return_home")
    if not by_rule and not any(command.do == "return_home" for command in mission.schedule):
        return
    way_m, name = max(ways) if by_rule else min(ways)
    timeout_s = seconds(rules.home.timeout_ns)
    needed_s = (way_m - rules.home.tolerance_m) / speed_mps
    if needed_s > timeout_s:
        text = f"home is {way_m:.0f} m from {name}: {needed_s:.0f} s at {speed_mps:.2f} m/s, and has {timeout_s:g} s"
        yield Finding("timeout", ("onboard", "home", "timeout_s"), text)
