"""Texts of what is wrong with a value of a file, from pydantic's errors: what is expected, and what was found."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic_core import ErrorDetails

from waypointctl.display_text import shown
from waypointctl.mission.quantity import Bare, how_to_write, twice_text, unit_of
from waypointctl.mission.yaml_tree import DataPath
from waypointctl.units import bare_name

MAPPING: Final = "a mapping (key: value)"

# What pydantic's error types expect of a value; {names} are filled from the error's context.
_EXPECTED: Final = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_parsing_size": "a whole number of at most 4,300 digits",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "string_type": "text",
    "string_unicode": "text",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": MAPPING,
    "model_type": MAPPING,
    "model_attributes_type": MAPPING,
    "finite_number": "a finite number",
    "multiple_of": "a multiple of {multiple_of}",
    "literal_error": "{expected}",
    "enum": "{expected}",
    "string_too_short": "text of at least {min_length} characters",
    "string_too_long": "text of at most {max_length} characters",
    "string_pattern_mismatch": "text of the form {pattern}",
}
# Error types of numbers out of range: the name of the bound in the context, and its words.
_BOUNDS: Final = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}
_MOST_GROUPED: Final = 1e12  # numbers below this are shown with commas


@dataclass(frozen=True, slots=True)
class Mismatch:
    """A value that is not what a branch of a union, or a field, expects."""

    found: str
    expected: str  # "a number", to be joined with what other branches expect
    hint: str  # empty, or from "; " on
    sentence: str  # what is wrong where this branch is the only one

    def __str__(self) -> str:
        """Return the sentence with its hint."""
        return self.sentence + self.hint


Text: TypeAlias = str | Mismatch


def joined(texts: list[Text]) -> str:
    """Return several errors at one place as one: they are the branches of a union, and none of them fits."""
    parts = [_mismatch(text) for text in texts]
    known = [part for part in parts if part is not None]
    if len(texts) == 1 or len(known) < len(texts) or len({part.found for part in known}) > 1:
        return ", or ".join(map(str, texts))
    expected = " nor ".join(part.expected for part in known)
    return f"{known[0].found} is neither {expected}{''.join(part.hint for part in known)}"


def _mismatch(text: Text) -> Mismatch | None:
    """Return a text of a field's own validator, "x is not y; hint", in its parts; None where it is none."""
    if isinstance(text, Mismatch):
        return text
    parts = re.fullmatch(r"([^ ]+) is not ([^;]+)(;.*)?", text)
    return Mismatch(parts[1], parts[2], parts[3] or "", text) if parts else None


def value_text(details: ErrorDetails, path: DataPath, value: object, owners: Iterable[type[BaseModel]]) -> Text:
    """Return what is wrong with a value.

    Args:
        details: pydantic's error.
        path: of the value in the file.
        value: as the file has it.
        owners: models that may have the field.
    """
    kind, context, given = details["type"], details.get("ctx", {}), details["input"]
    if isinstance(given, Bare) and given.twice:
        return twice_text(given.field)
    if kind == "value_error":
        return str(context["error"])
    field = next((part for part in reversed(details["loc"]) if isinstance(part, str)), "")
    if kind == "too_short":
        entries = "entry" if context["actual_length"] == 1 else "entries"
        return f"has {context['actual_length']} {entries}; at least {context['min_length']} are needed"
    if kind == "too_long":
        found = len(value) if isinstance(value, list) else context["actual_length"]
        return f"at most {_bound_text(context['max_length'])} entries are allowed; found {_bound_text(found)}"
    if kind in _BOUNDS:
        return _out_of_range(kind, context, field, value, owners)
    if kind not in _EXPECTED:
        return details["msg"]
    # A number as people write it: 0, not 0.0.
    context = {name: int(it) if isinstance(it, float) and it.is_integer() else it for name, it in context.items()}
    expected = _EXPECTED[kind].format(**context)
    if kind == "float_type" and bare_name(field):
        return f"{shown(value)} is not {_number_hint(field, path)}"
    if expected == MAPPING:
        found = "a list" if isinstance(value, list) else shown(value)
        return Mismatch(shown(value), expected, "", f"expected {expected}, found {found}")
    if kind in ("literal_error", "enum"):
        one_of = "one of " if " or " in expected else ""
        return Mismatch(
            shown(value), expected, _nearest(value, context), f"expected {one_of}{expected}; got {shown(value)}"
        )
    return Mismatch(shown(value), expected, "", f"{shown(value)} is not {expected}")


def _bound_text(number: float) -> str:
    """Return a bound as people write it: 10,000 or 0.001."""
    if float(number).is_integer() and abs(number) < _MOST_GROUPED:
        return f"{int(number):,}"
    return str(number)


def _out_of_range(
    kind: str, context: Mapping[str, Any], field: str, value: object, owners: Iterable[type[BaseModel]]
) -> Mismatch:
    name, words = _BOUNDS[kind]
    bound = context[name]
    # Text that has come as far as this is a number with its unit, and needs no quotes.
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    got = value if isinstance(value, str) else _shown_number(value) if is_number else shown(value)
    if isinstance(bound, int):
        least, most = _whole_bounds(field, owners)
        if least is not None and most is not None:
            expected = f"a whole number from {least} to {most}"
            return Mismatch(got, expected, "", f"expected {expected}; got {got}")
        if kind in ("greater_than", "less_than"):
            bound, words = (bound + 1, "at least") if kind == "greater_than" else (bound - 1, "at most")
    unit = unit_of(field) if bare_name(field) else ""
    if not unit and isinstance(value, str) and isinstance(bound, int | float):  # a share, the only text without a unit
        bound, unit = 100 * bound, "%"
    elif unit and is_number:
        got = f"{got} {unit}"
    expected = f"{words} {_bound_text(bound)}{' ' * bool(unit)}{unit}"
    return Mismatch(got, expected, "", f"must be {expected}; got {got}")


def _shown_number(value: Any) -> str:
    """Return a number as the file has it, without the zeros of a long float."""
    short = f"{value:g}" if isinstance(value, float) else shown(value)
    return short if isinstance(value, int) or float(short) == value or value != value else shown(value)


def _whole_bounds(field: str, owners: Iterable[type[BaseModel]]) -> tuple[int | None, int | None]:
    """Return the least and the most that a field of a whole number may be, None where there is no such bound."""
    least = most = None
    for owner in owners:
        info = owner.model_fields.get(field)
        for part in info.metadata if info and info.annotation is int else ():
            match part:
                case Ge(ge=int(bound)):
                    least = bound
                case Gt(gt=int(bound)):
                    least = bound + 1
                case Le(le=int(bound)):
                    most = bound
                case Lt(lt=int(bound)):
                    most = bound - 1
    return least, most


def _nearest(value: object, context: Mapping[str, object]) -> str:
    """Return which of the allowed words was probably meant, where one is near."""
    if not isinstance(value, str):
        return ""
    import difflib  # 10 ms that a good file need not wait for

    near = difflib.get_close_matches(value, re.findall(r"'([^']*)'", str(context["expected"])), n=1)
    return f"; did you mean '{near[0]}'?" if near else ""


def _number_hint(field: str, path: DataPath) -> str:
    """Return what a value is not, and what to write instead, where a field takes a number with a unit."""
    bare = bare_name(field)
    if isinstance(path[-1], int):
        return f"a number; numbers in {unit_of(field)} go under '{field}', numbers with a unit under '{bare}'"
    return f"a number{' with its unit' if bare in path else ''}; {how_to_write(field, 1)}"


def missing_text(part: str | int) -> str:
    """Return that an entry of a list, or a key, is missing, with the ways to write it."""
    if isinstance(part, int):
        return "is missing"
    bare = bare_name(part)
    hint = "" if bare is None else f"; write '{bare}: ...' with a unit, or '{part}: ...' in {unit_of(part)}"
    return f"required key {bare or part!r} is missing{hint}"
