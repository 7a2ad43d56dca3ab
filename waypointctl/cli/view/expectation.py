"""What a mission comes to without being flown, in a line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from waypointctl.ops.forecast.duration import Expected
    from waypointctl.ops.forecast.forecast import Forecast

_LIKELY: Final = 0.95  # what is more likely is not worth a word


def expectation(found: Forecast) -> str:
    """Return how a mission is expected to end and how long it takes, and would take under the other autonomies."""
    own = found.own
    others = ", ".join(f"{each.autonomy} {_time(each)}" for each in found.expected if each.autonomy != own.autonomy)
    without = f"; not counted: {', '.join(found.not_counted)}" if found.not_counted else ""
    return f"{_own(own, found.chance)} ({others}) at {found.speed.mps:.2f} m/s, {found.speed.source}{without}"


def _own(own: Expected, chance: float) -> str:
    if own.time_s is None:
        return f"not completed: {_why(own)}"
    if own.fails:
        return f"not completed: {own.fails}, and {own.time_s:.1f} s are expected"
    return f"expected {own.time_s:.1f} s" + (f" with a probability of {chance:.0%}" if chance < _LIKELY else "")


def _why(own: Expected) -> str:
    if own.blocked is not None:
        what = "a command" if own.blocked.way == "up" else "an answer"
        return f"{what} that is ready at {own.blocked.ready_s:.1f} s never gets through"
    return "the robot falls" if own.falls else own.fails or "never ends"


def _time(each: Expected) -> str:
    if each.falls:
        return "a fall"
    return "never" if each.time_s is None else f"{each.time_s:.1f} s"
