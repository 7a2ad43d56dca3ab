"""Durations, distances, angles, rates and sizes with their units, and simulation time in nanoseconds."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from decimal import Decimal
from typing import Final

NS_PER_S: Final = 1_000_000_000

DURATION_UNITS_S: Final = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
DISTANCE_UNITS_M: Final = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3}
ANGLE_UNITS_DEG: Final = {"deg": 1.0, "rad": 180.0 / math.pi}
ANGLE_UNITS_RAD: Final = {"rad": 1.0, "deg": math.pi / 180.0}
FREQUENCY_UNITS_HZ: Final = {"mHz": 1e-3, "Hz": 1.0, "kHz": 1e3}
RATE_UNITS_BPS: Final = {"bit/s": 1.0, "kbit/s": 1e3, "Mbit/s": 1e6, "Gbit/s": 1e9}
SIZE_UNITS_BYTES: Final = {"B": 1.0, "kB": 1e3, "KiB": 1024.0, "MB": 1e6, "MiB": 1024.0**2}
SHARE_UNITS: Final = {"%": 1e-2}

# A name that ends in one of these carries its unit: timeout_s, tolerance_m, heading_deg, rate_hz, queue_bytes.
UNITS_BY_SUFFIX: Final[Mapping[str, Mapping[str, float]]] = {
    "s": DURATION_UNITS_S,
    "m": DISTANCE_UNITS_M,
    "deg": ANGLE_UNITS_DEG,
    "rad": ANGLE_UNITS_RAD,
    "hz": FREQUENCY_UNITS_HZ,
    "bps": RATE_UNITS_BPS,
    "bytes": SIZE_UNITS_BYTES,
}

NUMBER_PATTERN: Final = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"

_QUANTITY: Final = re.compile(rf"\s*({NUMBER_PATTERN})\s*([A-Za-z/%]+)\s*")


def quantity(text: str, units: Mapping[str, float]) -> float:
    """Read a number with its unit, such as "1.28 s" or "50 ms", in the base unit of `units`.

    The product is rounded once: "70 cm" is the very float that 0.7 is. A number beyond
    all floats is infinite, one below them is 0.

    Raises:
        ValueError: the text is not a number followed by one of `units`.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with a unit ({', '.join(units)})")
    number, unit = match.groups()
    if unit not in units:
        raise ValueError(f"{text!r} has the unit {unit!r}; allowed are {', '.join(units)}")
    value = float(number)
    if not value or not math.isfinite(value):
        return value  # its exponent may be beyond what Decimal takes
    return float(Decimal(number) * Decimal(repr(units[unit])))


def number_in(text: str) -> str | None:
    """Return the number of a text that is a number with whatever unit ("0" of "0 ft"), None for any other text."""
    match = _QUANTITY.fullmatch(text)
    return match.group(1) if match else None


def bare_name(name: str) -> str | None:
    """Return a name without the unit it ends in ("timeout_s": "timeout"), or None if it carries none."""
    bare, _, suffix = name.rpartition("_")
    return bare if bare and suffix in UNITS_BY_SUFFIX else None


def ns(seconds: float) -> int:
    """Return a duration in [s] as whole nanoseconds."""
    return round(seconds * NS_PER_S)


def whole_ns(seconds: float) -> int:
    """Return a duration of more than 0 [s] as whole nanoseconds, at least 1."""
    return max(ns(seconds), 1)


def seconds(time_ns: int) -> float:
    """Return a time in [ns] as seconds."""
    return time_ns / NS_PER_S
