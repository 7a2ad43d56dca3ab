"""The base of the models that people write as files: strict, frozen, and kind about how a thing is written.

Spellings besides the fields' own names are declared, and the JSON Schema has the same:

- a field with a `Quantity` also goes by its bare name, with the unit in the value (see quantity.py);
- `list_shorthand` names the field of a bare list in place of the mapping;
- `text_shorthand` names the field of a bare word in place of the mapping;
- `keys_for_each` names fields of one and the same FileModel whose keys may be written once for all of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError

from waypointctl.mission.quantity import Quantity, bare_values, unit_of, units_of
from waypointctl.units import NUMBER_PATTERN, bare_name

Schema = dict[str, Any]


class FileModel(BaseModel):
    """A part of a file."""

    # A model inside another one is only ever built as its part: building each by itself would double the start-up time.
    model_config = ConfigDict(frozen=True, extra="forbid", field_title_generator=lambda name, _: name, defer_build=True)

    list_shorthand: ClassVar[str | None] = None
    text_shorthand: ClassVar[str | None] = None
    keys_for_each: ClassVar[tuple[str, ...]] = ()
    former_keys: ClassVar[Mapping[str, str]] = {}  # of earlier versions, and what to write now: for messages alone

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Check that the quantities of a new model are in the units that its fields' names end in."""
        for name, field in cls.model_fields.items():
            for quantity in _quantities((field.annotation, *field.metadata)):
                if not name.endswith(f"_{quantity.unit}"):
                    raise TypeError(f"{cls.__name__}.{name} is in {quantity.unit}: its name has to end in that")

    @classmethod
    def bare_names(cls) -> dict[str, str]:
        """Return the fields that may be written with the unit in the value: bare name to field."""
        names = {}
        for name, field in cls.model_fields.items():
            bare = bare_name(name)
            if bare is not None and _quantities((field.annotation, *field.metadata)):
                names[bare] = name
        return names

    @classmethod
    def known_keys(cls) -> tuple[str, ...]:
        """Return every key that a file may have here."""
        shared = cls.shared_model()
        return (*cls.model_fields, *cls.bare_names(), *(shared.known_keys() if shared else ()))

    @classmethod
    def renamed(cls, key: str) -> str | None:
        """Return what a key of an earlier version is called now, None where it is not one."""
        shared = cls.shared_model()
        return cls.former_keys.get(key) or (shared.renamed(key) if shared else None)

    @classmethod
    def list_keys(cls) -> tuple[str, ...]:
        """Return the field of a bare list here, and its bare name where it has one."""
        field = cls.list_shorthand
        return () if field is None else (field, *(bare for bare, name in cls.bare_names().items() if name == field))

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, given: Any) -> Any:
        """Convert a file's spellings into the fields' own names; the fields report what is wrong."""
        if isinstance(given, list | tuple) and cls.list_shorthand is not None:
            has_text = any(isinstance(part, str) for part in given)
            given = {cls.list_keys()[-1 if has_text else 0]: list(given)}
        if isinstance(given, str) and cls.text_shorthand is not None:
            given = {cls.text_shorthand: given}
        if not isinstance(given, dict):
            return given
        data = cls._spread(given)
        for bare, name in cls.bare_names().items():
            if bare in data:
                length = _list_length(cls.model_fields[name].annotation)
                data[name] = bare_values(name, data.pop(bare), twice=name in data, length=length)
        return data

    @classmethod
    def _spread(cls, given: dict[Any, Any]) -> dict[Any, Any]:
        """Hand the keys that are written once for all of `keys_for_each` to each of them."""
        model = cls.shared_model()
        shared = [key for key in model.known_keys() if key in given] if model else []
        if not shared:
            return dict(given)
        for name in cls.keys_for_each:
            if name in given:
                problem = f"'{shared[0]}' is for {' and '.join(cls.keys_for_each)}, and '{name}' is there too: keep one"
                raise PydanticCustomError("shared_key", "{problem}", {"problem": problem})
        data = {key: value for key, value in given.items() if key not in shared}
        return data | {name: {key: given[key] for key in shared} for name in cls.keys_for_each}

    @classmethod
    def shared_model(cls) -> type[FileModel] | None:
        """Return the model of the fields whose keys may be written once for all of them; None where there is none."""
        return model_in(cls.model_fields[cls.keys_for_each[0]].annotation) if cls.keys_for_each else None

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Describe every spelling that `_from_file` reads."""
        schema = handler.resolve_ref_schema(handler(core))
        describe_spellings(cls, schema, handler)
        return schema


def models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the models in a field's annotation."""
    if isinstance(annotation, type) and not get_args(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from models_in(part)


def model_in(annotation: Any) -> type[FileModel] | None:
    """Return the first file model in a field's annotation."""
    return next((model for model in models_in(annotation) if issubclass(model, FileModel)), None)


def _list_length(annotation: Any) -> int | None:
    """Return how many entries a list of a field must have, None where any number is allowed or it is not a list."""
    if get_origin(annotation) is tuple:
        entries = get_args(annotation)
        return None if Ellipsis in entries else len(entries)
    lengths = {_list_length(part) for part in get_args(annotation)} - {None}
    return lengths.pop() if len(lengths) == 1 else None


def _quantities(parts: tuple[Any, ...]) -> list[Quantity]:
    """Return the quantities among the parts of a field's annotation, and in what those are made of."""
    inner = [quantity for part in parts for quantity in _quantities((*get_args(part), *_metadata(part)))]
    return [part for part in parts if isinstance(part, Quantity)] + inner


def _metadata(part: Any) -> tuple[Any, ...]:
    return tuple(getattr(part, "__metadata__", ()))


def model_schema(model: type[FileModel], title: str) -> Schema:
    """Return the JSON Schema of a whole file, in the draft that YAML editors know best."""
    return {"$schema": "http://json-schema.org/draft-07/schema#", **model.model_json_schema(), "title": title}


def describe_spellings(model: type[FileModel], schema: Schema, handler: GetJsonSchemaHandler) -> None:
    """Add to a model's schema, in place, the spellings that the model reads besides its fields' names."""
    for field in schema["properties"].values():
        _plain_items(field)
    for bare, name in model.bare_names().items():
        _add_bare(schema, bare, name)
    if model.keys_for_each:
        _add_shared_keys(schema, model.keys_for_each, handler)
    shorthand_fields = model.list_keys() if model.text_shorthand is None else (model.text_shorthand,)
    if shorthand_fields:
        shorthands = [schema["properties"][key] for key in shorthand_fields]
        as_mapping = dict(schema)
        schema.clear()
        schema["anyOf"] = [*shorthands, as_mapping]


def _plain_items(schema: Schema) -> None:
    """Describe a tuple of like things as a list of them; draft 7 has no prefixItems."""
    items = schema.get("prefixItems")
    if items and all(item == items[0] for item in items):
        del schema["prefixItems"]
        schema["items"] = items[0]
    for part in schema.get("anyOf", []):
        _plain_items(part)


def _add_bare(schema: Schema, bare: str, name: str) -> None:
    """Let the field be written under its bare name; never under both."""
    properties = schema["properties"]
    properties[bare] = {**_with_unit(properties[name], name), "title": bare}
    one_of_them = [{"required": [name]}, {"required": [bare]}]
    rules = schema.setdefault("allOf", [])
    if name in schema.get("required", []):
        schema["required"].remove(name)
        rules.append({"oneOf": one_of_them})
    else:
        rules.append({"not": {"allOf": one_of_them}})


def _with_unit(schema: Schema, field: str) -> Schema:
    """Return a schema with text that ends in a unit wherever `schema` has a number."""
    if schema.get("type") == "number":
        label = f"a number with a unit, such as 1.5 {unit_of(field)}"
        return {"type": "string", "pattern": _pattern(field), "description": schema.get("description", label)}
    copy = {key: value for key, value in schema.items() if key != "default"}
    if "anyOf" in schema:
        copy["anyOf"] = [_with_unit(part, field) for part in schema["anyOf"] if part.get("type") != "null"]
    if "items" in schema:
        copy["items"] = _with_unit(schema["items"], field)
    return copy


def _pattern(field: str) -> str:
    return rf"^\s*{NUMBER_PATTERN}\s*({'|'.join(units_of(field))})\s*$"


def _add_shared_keys(schema: Schema, fields: tuple[str, ...], handler: GetJsonSchemaHandler) -> None:
    """Let the keys of the fields' one model be written once for all of them; not beside one of the fields."""
    properties = schema["properties"]
    shared = handler.resolve_ref_schema({"$ref": properties[fields[0]]["$ref"]})
    properties.update({key: value for key, value in shared["properties"].items() if key not in properties})
    written_out = [{"required": [field]} for field in fields]
    written_once = [{"required": [key]} for key in shared["properties"]]
    rules = schema.setdefault("allOf", [])
    rules.append({"not": {"allOf": [{"anyOf": written_out}, {"anyOf": written_once}]}})
    rules.extend(shared.get("allOf", []))
