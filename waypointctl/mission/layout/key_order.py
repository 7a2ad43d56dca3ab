"""The order of keys: that of the model's fields, whatever they are called in the file."""

from __future__ import annotations

from typing import Any, get_args

from pydantic.fields import FieldInfo

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.layout.nodes import Collection, Entry, Node
from waypointctl.mission.yaml_tree import plain


def sort_keys(node: Node, model: type[FileModel] | None) -> None:
    """Bring the keys of a part of a file, and of all in it, into their model's order, in place."""
    if not isinstance(node, Collection):
        return
    if node.is_mapping and model is not None:
        ranks = _ranks(model)
        node.entries.sort(key=lambda entry: ranks.get(_name(entry), len(ranks)))
    for entry in node.entries:
        inner = _model_of(_field(model, _name(entry))) if node.is_mapping and model is not None else model
        sort_keys(entry.node, inner)


def _ranks(model: type[FileModel]) -> dict[str, int]:
    """Return the place of each key that a model reads; those that are for each of several fields come last."""
    fields = list(model.model_fields)
    ranks = {name: rank for rank, name in enumerate(fields)}
    ranks |= {bare: ranks[name] for bare, name in model.bare_names().items()}
    shared = _shared(model)
    if shared is not None:
        ranks |= {key: rank + len(fields) for key, rank in _ranks(shared).items() if key not in ranks}
    return ranks


def _field(model: type[FileModel], key: str) -> FieldInfo | None:
    name = model.bare_names().get(key, key)
    if name in model.model_fields:
        return model.model_fields[name]
    shared = _shared(model)
    return None if shared is None else _field(shared, key)


def _shared(model: type[FileModel]) -> type[FileModel] | None:
    return _model_of(model.model_fields[model.keys_for_each[0]]) if model.keys_for_each else None


def _model_of(field: FieldInfo | None) -> type[FileModel] | None:
    """Return the model of a field's value, or of the elements of its list."""
    return None if field is None else _model_in(field.annotation)


def _model_in(annotation: Any) -> type[FileModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, FileModel):
        return annotation
    return next(filter(None, (_model_in(part) for part in get_args(annotation))), None)


def _name(entry: Entry) -> str:
    """Return a key without its quotes."""
    key = entry.key or ""
    if key[:1] in ("'", '"'):
        return key[1:-1]
    value = plain(key)
    return value if isinstance(value, str) else key
