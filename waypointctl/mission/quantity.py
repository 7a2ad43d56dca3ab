"""Numbers with a unit, and probabilities, as fields of a model that people write in a file.

    timeout_s: Annotated[float, Quantity("s", gt=0)] = 30.0

The field's name ends in the unit. In a file it is written as `timeout_s: 20` or, under the bare name, as
`timeout: 20 s`; FileModel hands a value found under the bare name on as `Bare`. A probability is 0.01 or 1 %.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, Field, GetCoreSchemaHandler, WithJsonSchema
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from waypointctl.display_text import shown
from waypointctl.units import NUMBER_PATTERN, SHARE_UNITS, UNITS_BY_SUFFIX, bare_name, number_in, quantity


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


@dataclass(frozen=True, slots=True)
class Bare:
    """A value as a file has it under a field's bare name, where a number needs its unit."""

    field: str  # the field's name, with its unit
    value: object
    whole: object  # the whole value under the name: the value, or the list that it is in
    twice: bool = False  # the file has the field under both of its names
    length: int | None = None  # that a list must have here, if it must have one


@dataclass(frozen=True, slots=True)
class Quantity:
    """Field metadata: a finite float in `unit`, which the field's name ends in, within bounds in that unit."""

    unit: str
    gt: float | None = None
    ge: float | None = None
    le: float | None = None

    def __post_init__(self) -> None:
        """Refuse a unit that no text can be read in."""
        if self.unit not in UNITS_BY_SUFFIX:
            raise ValueError(f"{self.unit!r} is not a unit that a name ends in: {', '.join(UNITS_BY_SUFFIX)}")

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Build the validator: numbers alone, read from text where the unit has to be in the text."""
        number = core_schema.float_schema(gt=self.gt, ge=self.ge, le=self.le, allow_inf_nan=False, strict=True)
        return core_schema.no_info_before_validator_function(partial(_to_number, self), number)

    def fits(self, number: float) -> bool:
        """Return whether a number in `unit` is finite and within the bounds."""
        within = (
            self.gt is None or number > self.gt,
            self.ge is None or number >= self.ge,
            self.le is None or number <= self.le,
        )
        return abs(number) <= sys.float_info.max and all(within)


def _to_number(own: Quantity, given: object) -> object:
    """Return what was written under a bare name as a number in the field's unit.

    Raises:
        PydanticCustomError: it has no unit, one that does not fit, or is written under both names.
    """
    if not isinstance(given, Bare):
        return given
    value = given.value
    if given.twice:
        problem = twice_text(given.field)
        raise PydanticCustomError("both_spellings", "{problem}", {"problem": problem})
    if isinstance(value, str):
        try:
            return quantity(value, units_of(given.field))
        except ValueError as error:
            raise PydanticCustomError("quantity", "{problem}", {"problem": str(error)}) from error
    if isinstance(value, int | float) and not isinstance(value, bool):
        problem = f"{shown(value)} has no unit; {_hint(own, given, value)}"
        raise PydanticCustomError("unit_missing", "{problem}", {"problem": problem})
    return value


def twice_text(field: str) -> str:
    """Return that a file has a field under both of its names."""
    return f"is given as '{bare_name(field)}' and as '{field}': keep one"


def _hint(own: Quantity, given: Bare, value: float) -> str:
    if isinstance(given.whole, list):
        return how_to_write_list(given.field, given.whole, given.length, own.fits)
    return how_to_write(given.field, value if own.fits(value) else 1)


def bare_values(field: str, value: object, *, twice: bool = False, length: int | None = None) -> object:
    """Mark the value under a field's bare name, or each element of a list.

    `length` is what a list must have here, if it must have one. Of several numbers without a unit only the first is
    marked: one error, one message.
    """
    if twice or not isinstance(value, list):
        return Bare(field, value, value, twice)
    marked: list[object] = []
    unitless_seen = False
    for element in value:
        unitless = not isinstance(element, str)
        marked.append(element if unitless and unitless_seen else Bare(field, element, value, length=length))
        unitless_seen = unitless_seen or unitless
    return marked


def _to_probability(given: object) -> object:
    """Return a share as a number.

    Raises:
        PydanticCustomError: it is text that is none.
    """
    if not isinstance(given, str):
        return given
    try:
        return quantity(given, SHARE_UNITS)
    except ValueError:
        problem = f"{shown(given)} is not a probability; write a number from 0 to 1, or a share such as '2 %'"
        raise PydanticCustomError("probability", "{problem}", {"problem": problem}) from None


_SCHEMA: dict[str, Any] = {
    "anyOf": [
        {"type": "number", "minimum": 0, "maximum": 1},
        {"type": "string", "pattern": rf"^\s*{NUMBER_PATTERN}\s*%\s*$"},
    ],
    "description": "a number from 0 to 1, or a share such as 2 %",
}

Probability: TypeAlias = Annotated[
    float,
    BeforeValidator(_to_probability),
    Field(ge=0, le=1, allow_inf_nan=False, strict=True),
    WithJsonSchema(_SCHEMA),
]
