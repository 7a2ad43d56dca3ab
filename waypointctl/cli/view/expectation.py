"""What a mission comes to without being flown, in a line."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from waypointctl.ops.forecast.duration import Expected
    from waypointctl.ops.forecast.forecast import Forecast


def expectation(found: Forecast) -> str:
    """Return how long a mission is expected to take, and would take under the other autonomies."""
    others = ", ".join(
        f"{each.autonomy} {_time(each)}" for each in found.expected if each.autonomy != found.own.autonomy
    )
    without = f"; not counted: {', '.join(found.not_counted)}" if found.not_counted else ""
    return f"expected {_time(found.own)} ({others}) at {found.speed.mps:.2f} m/s, {found.speed.source}{without}"


def _time(each: Expected) -> str:
    if each.falls:
        return "a fall"
    return "never" if each.time_s is None else f"{each.time_s:.1f} s"
