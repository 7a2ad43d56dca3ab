"""Durations, distances and angles with their units, and simulation time in nanoseconds."""

from __future__ import annotations

import math
import re
from typing import Final

NS_PER_S: Final = 1_000_000_000

DURATION_UNITS_S: Final = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
DISTANCE_UNITS_M: Final = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3}
ANGLE_UNITS_DEG: Final = {"deg": 1.0, "rad": 180.0 / math.pi}

_QUANTITY: Final = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z]+)\s*")


def quantity(text: str, units: dict[str, float]) -> float:
    """Read a number with its unit, such as "1.28 s" or "50 ms", in the base unit of `units`.

    Raises:
        ValueError: the text is not a number followed by one of `units`.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with a unit ({', '.join(units)})")
    number, unit = match.groups()
    if unit not in units:
        raise ValueError(f"{text!r} has the unit {unit!r}; allowed are {', '.join(units)}")
    return float(number) * units[unit]


def ns(seconds: float) -> int:
    """Return a duration in [s] as whole nanoseconds."""
    return round(seconds * NS_PER_S)


def seconds(time_ns: int) -> float:
    """Return a time in [ns] as seconds."""
    return time_ns / NS_PER_S
