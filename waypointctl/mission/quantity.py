"""Numbers with a unit, and probabilities, as fields of a model that people write in a file.

    timeout_s: Annotated[float, Quantity("s", gt=0)] = 30.0

The field's name ends in the unit. In a file it is written as `timeout_s: 20` or, under the bare name, as
`timeout: 20 s`; FileModel hands a value found under the bare name on as `Bare`. A probability is 0.01 or 1 %.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, Field, GetCoreSchemaHandler, WithJsonSchema
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from waypointctl.mission.wording import how_to_write, how_to_write_list, shown, units_of
from waypointctl.units import NUMBER_PATTERN, SHARE_UNITS, UNITS_BY_SUFFIX, bare_name, quantity


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
    bare, value = bare_name(given.field), given.value
    if given.twice:
        problem = f"is given as '{bare}' and as '{given.field}': keep one"
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
