"""What is wrong with a file, each problem with its place: pydantic's errors in the file's own terms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from waypointctl.display_text import path_text, printable
from waypointctl.mission.file_model import FileModel, models_in
from waypointctl.mission.problem_text import Text, joined, missing_text, value_text
from waypointctl.mission.quantity import unit_of, units_of
from waypointctl.mission.yaml_tree import DataPath, Mark, Tree
from waypointctl.units import bare_name

_MOST_CHARACTERS: Final = 4000  # of a line of a message


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
    found: dict[tuple[Mark, str, str | int | None], list[Text]] = {}
    for details in map(_without_tags, error.errors(include_url=False)):
        if _is_echo(details, tree):
            continue
        mark, path, text = _placed(details, tree, model)
        lacking = details["loc"][-1] if details["type"] == "missing" else None
        texts = found.setdefault((mark, path, lacking), [])
        if text not in texts:
            texts.append(text)
    return [Problem(where, mark.line, mark.column, path, joined(t)) for (mark, path, _), t in found.items()]


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


def _is_echo(details: ErrorDetails, tree: Tree) -> bool:
    """Tell whether a list is called too short only because pydantic leaves out the entries that are wrong."""
    _, value = _in_file(details["loc"], tree.data)
    return details["type"] == "too_short" and isinstance(value, list) and len(value) >= details["ctx"]["min_length"]


def _placed(details: ErrorDetails, tree: Tree, model: type[BaseModel]) -> tuple[Mark, str, Text]:
    """Return where an error is, the path of its field in the file, and what is wrong there."""
    loc, kind = details["loc"], details["type"]
    path, value = _in_file(loc, tree.data)
    if kind == "missing":
        is_entry = isinstance(loc[-1], int)
        return tree.values[path], path_text((*path, loc[-1]) if is_entry else path), missing_text(loc[-1])
    if kind == "extra_forbidden":
        return tree.keys.get(path, tree.values[path]), path_text(path), _unknown_key_text(loc, model)
    return tree.values[path], path_text(path), value_text(details, path, value, _models_at(model, loc[:-1]))


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
