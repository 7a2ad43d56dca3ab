"""How messages put values, fields and units."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Final

from waypointctl.units import UNITS_BY_SUFFIX, bare_name, number_in, quantity

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
    """Return a path as "waypoints[2].name"; a key that is not a plain word is quoted."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            key = part if re.fullmatch(r"[\w-]+", part) else shown(part)
            text += f".{key}" if text else key
    return text


def counted(count: int, things: str) -> str:
    """Return how many there are: "1 number", "3 numbers"; the plural is given."""
    return f"{count} {things[:-1] if count == 1 else things}"


def units_of(field: str) -> Mapping[str, float]:
    """Return the units that a field may be written in, by the suffix of its name."""
    return UNITS_BY_SUFFIX[field.rpartition("_")[2]]


def unit_of(field: str) -> str:
    """Return the unit that a field's name ends in, as it is written: "Hz" for "rate_hz"."""
    return next(unit for unit, factor in units_of(field).items() if factor == 1.0)


def how_to_write(field: str, value: object) -> str:
    """Return a hint with a number in both spellings of a field."""
    return f"write '{bare_name(field)}: {value} {unit_of(field)}' or '{field}: {value}'"


def how_to_write_list(field: str, values: list[object], length: int | None, fits: Callable[[float], bool]) -> str:
    """Return a hint with the list that was meant, as it has to be written: what is wrong beside is fixed, too.

    Args:
        field: that the list is of, with its unit.
        values: as the file has them.
        length: that the list must have; None: any.
        fits: whether a number is within the field's bounds.
    """
    length = len(values) if length is None else length
    parts = [_with_unit(field, value, fits) for value in values[:length]]
    # An order that the numbers must have is kept by taking one twice.
    filler = next((part for part in parts if part is not None), f"1 {unit_of(field)}")
    written = [part or filler for part in parts] + [filler] * (length - len(parts))
    hint = f"write '{bare_name(field)}: [{', '.join(written)}]'"
    alike = len(values) == length and parts == [f"{value} {unit_of(field)}" for value in values]
    return f"{hint} or '{field}: {values}'" if alike else hint


def _with_unit(field: str, value: object, fits: Callable[[float], bool]) -> str | None:
    """Return one entry of a list as it should be written, None if no number can be made out or it is out of bounds."""
    unit = unit_of(field)
    if isinstance(value, str):
        text, number = value.strip(), number_in(value)
        if number is None:
            return None
        try:
            in_base = quantity(text, units_of(field))
        except ValueError:  # another kind of unit: the number may be meant
            text, in_base = f"{number} {unit}", float(number)
        return text if fits(in_base) else None
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    # 40 where at most 1 s is allowed is 40 ms, more likely than an error in the number.
    smaller = sorted((factor, name) for name, factor in units_of(field).items() if factor < 1.0)
    names = {unit: 1.0} | {name: factor for factor, name in reversed(smaller)}
    return next((f"{value} {name}" for name, factor in names.items() if fits(value * factor)), None)
