"""Write the reference of the library from its docstrings, as docs/api.md.

python docs/api.py
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator
from enum import Enum
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from pydantic import BaseModel

import waypointctl
from waypointctl.mission.file_model import FileModel

PAGE = Path(__file__).resolve().parent / "api.md"

TEXT = """\
# The library

<!-- Written by `python docs/api.py` from the docstrings: do not edit. -->

{intro}

The scripts in [examples](../examples) use it. Errors derive from `waypointctl.WaypointctlError`; its message says what
is wrong, where, what is allowed and what to do.

| name | what it is |
|---|---|
{contents}

{entries}
"""

_ORDER: Final = ("load_mission", "load_policy", "load_robot", "load_suite", "load_recipe", "fly", "verify", "open_log")
_ALIASES: Final = {
    id(
        waypointctl.Plugins
    ): "What `plugins=` takes: observation groups, reward terms, paths of Python files, or several.",
    id(waypointctl.PolicyState): "What `Policy.state` returns, `Mapping[str, NDArray]`: arrays (n, ...) by name.",
    id(waypointctl.Sink): "What takes the messages of a flight, `Callable[[messages.Message], None]`, as they happen.",
}
_SECTION: Final = re.compile(r"^(Args|Attributes|Raises|Returns):$", re.MULTILINE)
_ENTRY: Final = re.compile(r"^    (\*{0,2}\w[\w, ]*): (.*(?:\n {6,}.*)*)", re.MULTILINE)


def page() -> str:
    """Return the page as the docstrings have it now."""
    names = sorted(set(waypointctl.__all__) - {"__version__"}, key=_rank)
    objects = {name: getattr(waypointctl, name) for name in names}
    contents = (f"| [`{name}`](#{name.lower()}) | {_first_line(value)} |" for name, value in objects.items())
    entries = (_entry(name, value) for name, value in objects.items())
    intro = _prose(_doc(waypointctl))
    return TEXT.format(intro=intro, contents="\n".join(contents), entries="\n\n".join(entries))


def _rank(name: str) -> tuple[int, int, str]:
    """Functions first, in the order of their use, then classes, then errors."""
    value = getattr(waypointctl, name)
    if inspect.isclass(value):
        return (2 if issubclass(value, Exception) else 1, 0, name)
    return (0, _ORDER.index(name) if name in _ORDER else len(_ORDER), name)


def _doc(value: Any) -> str:
    return _ALIASES.get(id(value)) or inspect.getdoc(value) or ""


def _first_line(value: Any) -> str:
    return _doc(value).split("\n\n")[0].replace("\n", " ")


def _entry(name: str, value: Any) -> str:
    parts = [f"## {name}"]
    if inspect.isroutine(value):
        parts.append(_code(f"{name}{_signature(value)}"))
    parts.append(_prose(_doc(value)))
    if isinstance(value, ModuleType):
        parts += [_class(member) for member in vars(value).values() if _is_own_class(member, value)]
    elif inspect.isclass(value):
        parts += _members(value)
    return "\n\n".join(part for part in parts if part)


def _is_own_class(member: Any, module: ModuleType) -> bool:
    return inspect.isclass(member) and member.__module__ == module.__name__


def _class(kind: type) -> str:
    """Return a record or an enumeration of a module."""
    text = f"### {kind.__name__}\n\n{_prose(inspect.getdoc(kind) or '')}"
    if issubclass(kind, Enum):
        return f"{text}\n\n{', '.join(f'`{member.value}`' for member in kind)}"
    return f"{text}\n\n{_code(_fields(kind))}"


def _fields(kind: type) -> str:
    """Return the fields of a record as they stand in the source, and the comments on them."""
    lines = inspect.getsource(kind).splitlines()
    return "\n".join(line.strip() for line in lines if re.match(r"    (\w+:|#) ", line))


def _members(kind: type) -> Iterator[str]:
    described = inspect.getdoc(kind) or ""
    if issubclass(kind, BaseModel):
        if any(field.description for field in kind.model_fields.values()):
            yield "\n".join(_model_field(kind, name) for name in kind.model_fields)
        else:
            yield _code(_fields(kind))
    elif "__dataclass_fields__" in vars(kind) and "Attributes:" not in described:
        yield _code(_fields(kind))
    elif issubclass(kind, Enum):
        yield ", ".join(f"`{member.value}`" for member in kind)
    for name in sorted(_public(kind)):
        value = inspect.getattr_static(kind, name)
        function = value.__func__ if isinstance(value, classmethod | staticmethod) else value
        text = _prose(inspect.getdoc(function) or "")
        if isinstance(value, property | cached_property):
            yield f"**`{kind.__name__}.{name}`** {text}"
        elif inspect.isfunction(function):
            called = kind.__name__ if name == "__init__" else f"{kind.__name__}.{name}"
            yield f"{_code(f'{called}{_signature(function)}')}\n\n{text}"


def _public(kind: type) -> set[str]:
    """Return the names that a class and its bases in waypointctl define and document, validators left out."""
    own = [base for base in kind.__mro__ if base.__module__.startswith("waypointctl") and base is not FileModel]
    public = [base for base in own[1:] if base.__name__ in waypointctl.__all__]
    names = {name for base in own for name in vars(base) if not name.startswith("_")}
    names -= {name for base in public for name in vars(base)}
    if "__init__" in vars(kind) and not dataclasses.is_dataclass(kind) and not issubclass(kind, Exception | BaseModel):
        names |= {"__init__"} if inspect.getdoc(vars(kind)["__init__"]) else set()
    pydantic = set(dir(BaseModel)) if issubclass(kind, BaseModel) else set()
    return {name for name in names if name not in pydantic and inspect.getdoc(getattr(kind, name))}


def _model_field(kind: type[BaseModel], name: str) -> str:
    field = kind.model_fields[name]
    described = f": {field.description}" if field.description else ""
    return f"- `{name}`{'' if field.is_required() else ', optional'}{described}"


def _signature(function: Any) -> str:
    """Return a signature, a parameter a line where it is long; a default that is a function is an ellipsis."""
    signature = inspect.signature(function)
    kept = [parameter for name, parameter in signature.parameters.items() if name not in ("self", "cls")]
    kept = [each.replace(default=_DEFAULT) if inspect.isfunction(each.default) else each for each in kept]
    text = re.sub(r"(: |-> )'([^']*)'", r"\1\2", str(signature.replace(parameters=kept)))
    if len(text) <= 90:
        return text
    inner, _, returned = text[1:].rpartition(") -> ")
    return "(\n    " + ",\n    ".join(_split(inner)) + f",\n) -> {returned}"


class _Ellipsis:
    def __repr__(self) -> str:
        return "..."


_DEFAULT: Final = _Ellipsis()


def _split(parameters: str) -> Iterator[str]:
    """Split at the commas that are in no brackets."""
    depth, begin = 0, 0
    for place, letter in enumerate(parameters):
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and not depth:
            yield parameters[begin:place].strip()
            begin = place + 1
    yield parameters[begin:].strip()


def _prose(text: str) -> str:
    """Return a docstring as Markdown, its sections as lists."""
    plain, *sections = _SECTION.split(text)
    parts = [re.sub(r"(?m)^ {4}(?=\S)", "    ", plain.strip())]
    for title, body in zip(sections[::2], sections[1::2], strict=True):
        listed, _, rest = body.strip("\n").partition("\n\n")
        entries = (f"- `{name}`: {' '.join(said.split())}" for name, said in _ENTRY.findall(listed))
        parts.append("\n".join([f"{title}:", "", *entries]))
        parts.append(rest.strip())
    return "\n\n".join(part for part in parts if part)


def _code(text: str) -> str:
    return f"```python\n{text}\n```"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
