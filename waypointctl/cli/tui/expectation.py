"""What a mission comes to without being flown, in a line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from waypointctl.flight.forecast.duration import Expected
    from waypointctl.flight.forecast.forecast import Forecast

_LIKELY: Final = 0.95  # what is more likely is not worth a word


def expectation(found: Forecast) -> str:
    """Return how a mission is expected to end and how long it takes, and would take under the other autonomies."""
    own = found.own
    speed = f"{found.speed.mps:.2f} m/s ({found.speed.source})"
    others = ", ".join(f"{each.autonomy} {_time(each)}" for each in found.expected if each.autonomy != own.autonomy)
    without = f"; not counted: {', '.join(found.not_counted)}" if found.not_counted else ""
    return f"{_own(found, speed)}; other autonomies: {others}{without}"


def _own(found: Forecast, speed: str) -> str:
    own = found.own
    if own.time_s is None or own.fails:
        return f"expected to fail: {_why(own)}; computed at {speed}"
    least = "at least " if found.is_lower_bound else ""
    chance = f"; probability of completion {found.chance * 100:.0f} %" if found.chance < _LIKELY else ""
    return f"expected duration {least}{own.time_s:.1f} s at {speed}{chance}"


def _why(own: Expected) -> str:
    if own.blocked is not None:
        what = "a command" if own.blocked.way == "up" else "an answer"
        return f"{what} that is sent at {own.blocked.ready_s:.1f} s is never delivered"
    return "the robot falls" if own.falls else own.fails or "the mission never ends"


def _time(each: Expected) -> str:
    if each.falls:
        return "falls"
    return "not completed" if each.time_s is None else f"{each.time_s:.1f} s"
