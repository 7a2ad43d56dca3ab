"""List every key of a mission file, as docs/mission.md.

python docs/mission_keys.py
"""

from __future__ import annotations

import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen
from pydantic import WithJsonSchema
from pydantic.fields import FieldInfo

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Mission
from waypointctl.mission.presets import PRESETS
from waypointctl.mission.quantity import Quantity
from waypointctl.units import UNITS_BY_SUFFIX, bare_name

PAGE: Final = Path(__file__).resolve().parent / "mission.md"

TEXT: Final = """\
# The mission file, key by key

<!-- Written by `python docs/mission_keys.py` from waypointctl/mission/: do not edit. -->

A mission is YAML: one mapping, with the keys below. `waypointctl schema mission` prints the same for editors,
`waypointctl validate` checks a file against it, and `waypointctl fmt` formats it. Those in `missions/` are examples.

A quantity is written with its unit in the value, `timeout: 20 s`, or in the key, `timeout_s: 20`; under the bare key a
number without a unit is refused. Units: {units}.

Positions are x and y in metres in the world frame. `link.down` has the keys of `link.up`. In the column of defaults "-"
means that the key is not set, and "block" a block in which each key has its default.

`waypointctl fmt` puts keys into the order of the tables below, with two spaces a level. Quotes, numbers, units, blank
lines and block or brace style stay as written. A comment moves with the key that it stands above or behind; a comment
above the first key stays at the top. The file is not changed when its values or comments would not survive, which `fmt`
reports: a comment within braces or brackets, or an empty value in braces. Long text over several lines without quotes
becomes one line in double quotes; a byte order mark, `---` and CRLF line ends are removed. Files of up to 256 KiB are
formatted.

{sections}
## Presets of a link

For each direction. Keys beside `preset` override its values. Their sources are in `waypointctl/mission/presets.py`.

| preset | is |
|---|---|
{presets}
"""

_KINDS: Final = {
    "s": "a time",
    "m": "a length",
    "deg": "an angle",
    "rad": "an angle",
    "hz": "a frequency",
    "bps": "a rate",
    "bytes": "a size",
}
_SYMBOLS: Final = {"s": "s", "m": "m", "deg": "deg", "rad": "rad", "hz": "Hz", "bps": "bit/s", "bytes": "B"}
_DAY_S: Final = 86_400


def page() -> str:
    """Return the page as the models have it now."""
    units = ", ".join(f"`{unit}`" for unit in dict.fromkeys(unit for them in UNITS_BY_SUFFIX.values() for unit in them))
    presets = "\n".join(f"| `{name}` | {_preset(values)} |" for name, values in PRESETS.items())
    return TEXT.format(units=units, sections="\n".join(_sections()), presets=presets)


def _preset(values: Any) -> str:
    return ", ".join(f"`{_key(name)}: {value:g} {_unit(name)}`" for name, value in values.items())


def _sections() -> Iterator[str]:
    """Yield a section for each model, the mission first, in the order in which they are met."""
    for model, paths in _models().items():
        title = "The mission" if model is Mission else " and ".join(f"`{path}`" for path in paths)
        rows = "\n".join(_row(model, name, field) for name, field in model.model_fields.items())
        head = f"## {title}\n\n{_sentence(model)}\n"
        yield f"{head}\n| key | takes | default | what it is |\n|---|---|---|---|\n{rows}\n"


def _models() -> dict[type[FileModel], list[str]]:
    """Return each model that a mission is made of, and the keys that lead to it."""
    found: dict[type[FileModel], list[str]] = {Mission: []}
    waiting: list[tuple[type[FileModel], str]] = [(Mission, "")]
    while waiting:
        model, at = waiting.pop(0)
        for name, field in model.model_fields.items():
            for inner in _inner_models(field.annotation):
                path = f"{at}{name}"
                if inner not in found:
                    found[inner] = []
                    waiting.append((inner, f"{path}."))
                found[inner].append(path)
    return found


def _inner_models(annotation: Any) -> list[type[FileModel]]:
    if isinstance(annotation, type) and issubclass(annotation, FileModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _inner_models(part)]


def _sentence(model: type[FileModel]) -> str:
    return " ".join((model.__doc__ or "").split())


def _row(model: type[FileModel], name: str, field: FieldInfo) -> str:
    bare = next((bare for bare, long in model.bare_names().items() if long == name), name)
    takes = _takes(name, field.annotation, tuple(field.metadata))
    default = "**needed**" if field.is_required() else _default(name, field)
    return f"| `{bare}` | {takes} | {default} | {(field.description or _about(field)).replace('|', chr(92) + '|')} |"


def _about(field: FieldInfo) -> str:
    models = _inner_models(field.annotation)
    return _sentence(models[0]).removesuffix(".") if models else ""


def _takes(name: str, annotation: Any, metadata: tuple[Any, ...]) -> str:
    """Return what a field takes, in words."""
    parts, metadata = _unwrapped(annotation, metadata)
    return " or ".join(dict.fromkeys(_one(name, part, metadata) for part in parts))


def _unwrapped(annotation: Any, metadata: tuple[Any, ...]) -> tuple[list[Any], tuple[Any, ...]]:
    if get_origin(annotation) in (Union, types.UnionType):
        return [part for part in get_args(annotation) if part is not type(None)], metadata
    return [annotation], metadata


def _one(name: str, annotation: Any, metadata: tuple[Any, ...]) -> str:
    if hasattr(annotation, "__metadata__"):
        return _takes(name, annotation.__origin__, (*metadata, *annotation.__metadata__))
    if get_origin(annotation) in (Union, types.UnionType):
        return _takes(name, annotation, metadata)
    if get_origin(annotation) is Literal:
        return ", ".join(f"`{choice}`" for choice in get_args(annotation))
    if models := _inner_models(annotation):
        several = get_origin(annotation) is tuple
        path = _models()[models[0]][0]
        return f"{'a list of ' if several else ''}[`{path}`](#{_anchor(models[0])})"
    if get_origin(annotation) is tuple:
        entries = [part for part in get_args(annotation) if part is not Ellipsis]
        return f"[x, y], each {_one(name, entries[0], ())}"
    return _scalar(annotation, metadata)


def _scalar(annotation: Any, metadata: tuple[Any, ...]) -> str:
    quantity = next((part for part in metadata if isinstance(part, Quantity)), None)
    if quantity is not None:
        return f"{_KINDS[quantity.unit]}{_bounds(quantity.gt, quantity.ge, None, quantity.le, quantity.unit)}"
    if any(isinstance(part, WithJsonSchema) for part in metadata):
        return "a probability: 0 to 1, or a share such as 2 %"
    if annotation is bool:
        return "`true` or `false`"
    if annotation in (int, float):
        limits = {type(limit): limit for part in metadata for limit in (part, *getattr(part, "metadata", ()))}
        kind = "a whole number" if annotation is int else "a number"
        return f"{kind}{_bounds(_of(limits, Gt), _of(limits, Ge), _of(limits, Lt), _of(limits, Le), '')}"
    longest = next((limit.max_length for limit in metadata if isinstance(limit, MaxLen)), None)
    assert annotation is str, annotation
    return "a text" if longest is None else f"a text of at most {longest:,} letters"


def _of(limits: dict[type, Any], kind: type) -> Any:
    limit = limits.get(kind)
    return None if limit is None else getattr(limit, kind.__name__.lower())


def _bounds(gt: Any, ge: Any, lt: Any, le: Any, unit: str) -> str:
    symbol = f" {_SYMBOLS[unit]}" if unit else ""
    texts = []
    for words, limit in (("more than", gt), ("at least", ge), ("less than", lt), ("at most", le)):
        if limit is not None and unit == "s" and limit >= _DAY_S:
            texts.append(f"{words} {_number(limit / _DAY_S)} d")
        elif limit is not None and limit < 2**53:
            texts.append(f"{words} {_number(limit)}{symbol}")
    return f", {', '.join(texts)}" if texts else ""


def _default(name: str, field: FieldInfo) -> str:
    value = field.get_default(call_default_factory=True)
    if value is None or value == () or value == "":
        return "-"
    if isinstance(value, FileModel):
        return "block"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, float) and bare_name(name) is not None:
        return f"{_number(value)} {_unit(name)}"
    if isinstance(value, tuple):
        return f"[{', '.join(_number(part) for part in value)}] {_unit(name)}"
    return f"`{_number(value) if isinstance(value, float) else value}`"


def _key(name: str) -> str:
    return bare_name(name) or name


def _unit(name: str) -> str:
    return _SYMBOLS[name.rpartition("_")[2]]


def _number(value: float) -> str:
    return f"{value:,.10g}" if isinstance(value, float) else f"{value:,}"


def _anchor(model: type[FileModel]) -> str:
    """Return the anchor that the page's heading of a model gets."""
    title = " and ".join(_models()[model])
    return "".join(letter for letter in title.lower().replace(" ", "-") if letter.isalnum() or letter in "-_")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
