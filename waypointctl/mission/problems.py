"""What is wrong with a file, each problem with its place: pydantic's errors in the file's own terms."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from waypointctl.display_text import path_text, printable, shown
from waypointctl.mission.file_model import FileModel, models_in
from waypointctl.mission.quantity import how_to_write, unit_of, units_of
from waypointctl.mission.yaml_tree import DataPath, Mark, Tree
from waypointctl.units import bare_name

# What is wrong, by pydantic's error types; {names} are filled from the error's context.
_SAYS: Final = {
    "union_tag_invalid": "{discriminator} is '{tag}', not one of {expected_tags}",
    "union_tag_not_found": "{discriminator} is missing",
    "too_short": "has {actual_length} entries; at least {min_length} are needed",
    "too_long": "has more than the {max_length} entries that are allowed",
}

# What pydantic's error types expect of a value, in the same way.
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
    "dict_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "model_attributes_type": "a mapping of keys to values",
    "finite_number": "a finite number",
    "greater_than": "> {gt}",
    "greater_than_equal": ">= {ge}",
    "less_than": "< {lt}",
    "less_than_equal": "<= {le}",
    "multiple_of": "a multiple of {multiple_of}",
    "literal_error": "{expected}",
    "enum": "{expected}",
    "string_too_short": "text of at least {min_length} characters",
    "string_too_long": "text of at most {max_length} characters",
    "string_pattern_mismatch": "text of the form {pattern}",
}
_MOST_CHARACTERS: Final = 4000  # of a line of a message
_BOUNDS: Final = frozenset({"greater_than", "greater_than_equal", "less_than", "less_than_equal"})


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a file."""

    where: str  # the file
    line: int  # from 1; 0 where the problem has no line
    column: int  # from 1; 0 where the problem has no line
    path: str  # of the field, as "waypoints[2].tolerance_m"; empty for the file as a whole
    text: str

    @property
    def place(self) -> str:
        """The file, line and column, as editors and compilers write them."""
        return f"{self.where}:{self.line}:{self.column}" if self.line else self.where

    @property
    def sentence(self) -> str:
        """What is wrong, with the field."""
        return f"{self.path}: {self.text}" if self.path else self.text

    def __str__(self) -> str:
        """Return one line for people."""
        return f"{printable(self.place)}: {printable(self.sentence, _MOST_CHARACTERS)}"


def problems_of(error: ValidationError, tree: Tree, where: str, model: type[BaseModel]) -> list[Problem]:
    """Return what is wrong in the order of the file, each thing once."""
    found: dict[tuple[Mark, str], list[str]] = {}
    for details in map(_without_tags, error.errors(include_url=False)):
        if _is_echo(details, tree):
            continue
        mark, path, text = _placed(details, tree, model)
        texts = found.setdefault((mark, path), [])
        if text not in texts:
            texts.append(text)
    return [Problem(where, mark.line, mark.column, path, _joined(t)) for (mark, path), t in found.items()]


def duplicate_problems(tree: Tree, where: str) -> list[Problem]:
    """Return a problem for each duplicate key."""
    return [
        Problem(where, mark.line, mark.column, path_text(path), f"duplicate key, first in line {tree.keys[path].line}")
        for path, mark in tree.duplicates
    ]


def _without_tags(details: ErrorDetails) -> ErrorDetails:
    """Return an error of a union's tag as one of the field that has the tag."""
    if details["type"] not in ("union_tag_invalid", "union_tag_not_found"):
        return details
    context = details["ctx"]
    field = context["discriminator"].strip("'")
    loc = (*details["loc"], field)
    if details["type"] == "union_tag_not_found":
        return {**details, "type": "missing", "loc": loc}
    *others, last = context["expected_tags"].split(", ")
    expected = f"{', '.join(others)} or {last}" if others else last
    return {**details, "type": "literal_error", "loc": loc, "ctx": {"expected": expected}}


def _joined(texts: list[str]) -> str:
    """Return several errors at one place as one: they are the branches of a union, and none of them fits."""
    parts = [re.fullmatch(r"([^ ]+) is not ([^;]+)(;.*)?", text) for text in texts]
    if len(texts) == 1 or not all(parts) or len({part[1] for part in parts if part}) > 1:
        return ", or ".join(texts)
    expected = " nor ".join(part[2] for part in parts if part)
    hints = "".join(part[3] or "" for part in parts if part)
    return f"{texts[0].split(' ', 1)[0]} is neither {expected}{hints}"


def _is_echo(details: ErrorDetails, tree: Tree) -> bool:
    """Tell whether a list is called too short only because pydantic leaves out the entries that are wrong."""
    _, value = _in_file(details["loc"], tree.data)
    return details["type"] == "too_short" and isinstance(value, list) and len(value) >= details["ctx"]["min_length"]


def _placed(details: ErrorDetails, tree: Tree, model: type[BaseModel]) -> tuple[Mark, str, str]:
    """Return where an error is, the path of its field in the file, and what is wrong there."""
    loc, kind = details["loc"], details["type"]
    path, value = _in_file(loc, tree.data)
    if kind == "missing":
        name = loc[-1] if isinstance(loc[-1], int) else bare_name(loc[-1]) or loc[-1]
        return tree.values[path], path_text((*path, name)), _missing_text(loc)
    if kind == "extra_forbidden":
        return tree.keys.get(path, tree.values[path]), path_text(path), _unknown_key_text(loc, model)
    return tree.values[path], path_text(path), _value_text(details, path, value)


def _in_file(loc: Iterable[str | int], data: Any) -> tuple[DataPath, Any]:
    """Follow an error's location through the file's data, past what the file does not spell out.

    A field may be under its bare name, or absent where a shorthand implies it or pydantic names a
    union's branch.
    """
    path: list[str | int] = []
    for part in loc:
        if isinstance(data, dict):
            key = next((key for key in (part, bare_name(str(part))) if key in data), None)
        else:
            key = part if isinstance(data, list) and isinstance(part, int) and part < len(data) else None
        if key is not None:
            path.append(key)
            data = data[key]
    return tuple(path), data


def _value_text(details: ErrorDetails, path: DataPath, value: object) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind == "value_error":
        return str(context["error"])
    if kind not in _SAYS and kind not in _EXPECTED:
        return details["msg"]
    # A bound as people write it: 0, not 0.0.
    context = {name: int(it) if isinstance(it, float) and it.is_integer() else it for name, it in context.items()}
    if kind in _SAYS:
        return _SAYS[kind].format(**context).replace("has 1 entries", "has 1 entry")
    expected = _EXPECTED[kind].format(**context) + _nearest(kind, value, context)
    field = next((part for part in reversed(details["loc"]) if isinstance(part, str)), "")
    if kind == "float_type" and bare_name(field):
        return f"{shown(value)} is not {_number_hint(field, path)}"
    if kind in _BOUNDS and bare_name(field):
        # Text that has come as far as this is a number with its unit, and needs no quotes.
        return f"{value if isinstance(value, str) else shown(value)} is not {expected} {unit_of(field)}"
    return f"{shown(value)} is not {expected}"


def _nearest(kind: str, value: object, context: Mapping[str, object]) -> str:
    """Return which of the allowed words was probably meant, where one is near."""
    if kind not in ("literal_error", "enum") or not isinstance(value, str):
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


def _missing_text(loc: tuple[str | int, ...]) -> str:
    name, bare = str(loc[-1]), bare_name(str(loc[-1]))
    hint = "" if bare is None else f"; write '{bare}: ...' with a unit, or '{name}: ...' in {unit_of(name)}"
    return f"is missing{hint}"


def _unknown_key_text(loc: tuple[str | int, ...], model: type[BaseModel]) -> str:
    import difflib  # 10 ms that a good file need not wait for

    owners = _models_at(model, loc[:-1])
    known = list(dict.fromkeys(key for owner in owners for key in _known_keys(owner)))
    renamed = [new for owner in owners if issubclass(owner, FileModel) and (new := owner.renamed(str(loc[-1])))]
    near = renamed or difflib.get_close_matches(str(loc[-1]), known, n=1)
    if not near:
        return f"unknown key; allowed are {', '.join(known)}" if known else "unknown key; none is allowed here"
    return f"unknown key; did you mean {' or '.join(_spellings(near[0], known))}?"


def _spellings(key: str, known: list[str]) -> Iterator[str]:
    """Yield the ways to write the field of `key`."""
    with_unit = next((name for name in known if name == key or bare_name(name) == key), key)
    bare = bare_name(with_unit)
    if bare is None or bare not in known:
        yield f"'{key}'"
        return
    yield f"'{with_unit}' (a number in {unit_of(with_unit)})"
    yield f"'{bare}' (with its unit: {', '.join(units_of(with_unit))})"


def _known_keys(model: type[BaseModel]) -> tuple[str, ...]:
    if issubclass(model, FileModel):
        return model.known_keys()
    return tuple(field.alias or name for name, field in model.model_fields.items())


def _models_at(model: type[BaseModel], loc: Iterable[str | int]) -> list[type[BaseModel]]:
    """Return the models that are possible at an error's location."""
    models = [model]
    for part in loc:
        inner = [
            m
            for owner in models
            if part in owner.model_fields
            for m in models_in(owner.model_fields[str(part)].annotation)
        ]
        models = inner or models  # an index, or the name of a union's branch, leads no further down
    return models
