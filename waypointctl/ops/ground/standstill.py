"""Why a robot stands that could go on, as the ground can tell from its newest frame of telemetry and the mission."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from waypointctl.log.messages import Mode, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.ops.executive.rules import Rules, rules_of

_BESIDE_M: Final = (0.1, 0.3, 0.6, 1.0)  # how far the robot may have got from where it broke the fence
_TURNS: Final = 24  # directions that are looked at
_STOPPING: Final = ("hold", "return_home")
_NEARLY: Final = 1.5  # times home's tolerance: the robot stands a little way on from where it stopped


def why_it_stands(mission: Mission, frame: Telemetry | None) -> str:
    """Return what a robot waits for that stands with something left to do; empty for one that does not."""
    if frame is None:
        return ""
    if frame.mode is Mode.PAUSED:
        return "the robot holds by command"
    if frame.mode is Mode.WAITING:
        return f"the robot waits for the release of {_next_name(mission, frame)}"
    return _why_safe(mission, rules_of(mission), frame) if frame.mode is Mode.SAFE else ""


def _why_safe(mission: Mission, rules: Rules, frame: Telemetry) -> str:
    """Return which rule on board made the robot stand; where several may have, the likeliest one."""
    if "return_home" in (rules.then, rules.on_breach, rules.on_link_loss) and _is_at_home(rules, frame):
        return "the robot is at home, where a rule on board has sent it"
    breach = rules.fence.breach(frame.x_m, frame.y_m)
    if breach:
        return f"the robot stands where it {breach}"
    by_fence = _by_fence(rules, frame)
    after_leg = f"after a failed leg at {_next_name(mission, frame)}" if rules.then == "hold" else ""
    if after_leg or by_fence:
        return f"the robot holds {', or '.join(why for why in (after_leg, by_fence) if why)}"
    if rules.link_loss_ns and rules.on_link_loss == "hold":
        return "the robot holds because it hears nothing from the ground"
    named = ", ".join(_rules_that_stop(rules))
    return f"the robot stands by a rule on board ({named})" if named else "the robot stands by a rule on board"


def _by_fence(rules: Rules, frame: Telemetry) -> str:
    """Return which part of the fence a robot has stopped by that is just out of the breach again; empty for none.

    It walks on a little while it stops, and a frame of telemetry tells only where it was at some moment.
    """
    if rules.on_breach != "hold":
        return ""
    for radius_m in _BESIDE_M:
        for turn in range(_TURNS):
            angle_rad = 2 * math.pi * turn / _TURNS
            x_m, y_m = frame.x_m + radius_m * math.cos(angle_rad), frame.y_m + radius_m * math.sin(angle_rad)
            if breach := rules.fence.breach(x_m, y_m):
                return f"by the fence, just beside a place that {breach}"
    return ""


def _rules_that_stop(rules: Rules) -> Iterator[str]:
    """Yield the rules by which a robot may have come to stand, as the mission file has them."""
    if rules.fence.keep_in or rules.fence.keep_out:
        yield f"onboard.geofence.do: {rules.on_breach}"
    if rules.then in _STOPPING:
        yield f"on_failure: {rules.then}"
    if rules.link_loss_ns and rules.on_link_loss in _STOPPING:
        yield f"onboard.link_loss.do: {rules.on_link_loss}"


def _is_at_home(rules: Rules, frame: Telemetry) -> bool:
    home = rules.home
    away_m = math.dist((frame.x_m, frame.y_m), (home.x_m, home.y_m))
    return frame.target < 0 and away_m <= _NEARLY * home.tolerance_m


def _next_name(mission: Mission, frame: Telemetry) -> str:
    """Return the waypoint that the robot is about; where it does not say so, the first that it has not reached."""
    names = {leg.index: leg.name for leg in mission.legs()}
    if frame.target in names:
        return names[frame.target]
    return next((name for index, name in names.items() if index not in frame.reached), "its waypoint")
