"""A probability, as a field of a model that people write in a file: 0.01 or 1 %."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from waypointctl.mission.wording import shown
from waypointctl.units import NUMBER_PATTERN, SHARE_UNITS, quantity


def _to_number(given: object) -> object:
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
    BeforeValidator(_to_number),
    Field(ge=0, le=1, allow_inf_nan=False, strict=True),
    WithJsonSchema(_SCHEMA),
]
