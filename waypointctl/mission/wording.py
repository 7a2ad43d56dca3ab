"""How messages put values, fields and units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Final

from waypointctl.units import UNITS_BY_SUFFIX, bare_name

_MAX_SHOWN: Final = 60


def shown(value: object) -> str:
    """Return a value as a message shows it: as the file would have it, and short."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    text = repr(value)
    return text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}..."


def path_text(path: Iterable[str | int]) -> str:
    """Return a path as "waypoints[2].name"; a key that is no plain word is quoted."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            key = part if re.fullmatch(r"[\w-]+", part) else shown(part)
            text += f".{key}" if text else key
    return text


def units_of(field: str) -> Mapping[str, float]:
    """Return the units that a field may be written in, by the suffix of its name."""
    return UNITS_BY_SUFFIX[field.rpartition("_")[2]]


def unit_of(field: str) -> str:
    """Return the unit that a field's name ends in, as it is written: "Hz" for "rate_hz"."""
    return next(unit for unit, factor in units_of(field).items() if factor == 1.0)


def how_to_write(field: str, value: object) -> str:
    """Return a mend with a number, or a list of numbers, in both spellings of a field."""
    bare, unit = bare_name(field), unit_of(field)
    if isinstance(value, list):
        with_units = ", ".join(part if isinstance(part, str) else f"{part} {unit}" for part in value)
        mend = f"write '{bare}: [{with_units}]'"
        return mend if any(isinstance(part, str) for part in value) else f"{mend} or '{field}: {value}'"
    return f"write '{bare}: {value} {unit}' or '{field}: {value}'"
