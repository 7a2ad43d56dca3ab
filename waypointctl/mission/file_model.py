"""The base of the models that people write as files: strict, frozen, and kind about how a thing is written.

Spellings besides the fields' own names are declared, and the JSON Schema has the same:

- a field with a `Quantity` also goes by its bare name, with the unit in the value (see quantity.py);
- `list_shorthand` names the field of a bare list in place of the mapping;
- `text_shorthand` names the field of a bare word in place of the mapping;
- `keys_for_each` names fields of one and the same FileModel whose keys may be written once for all of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError

from waypointctl.mission.quantity import Quantity, bare_values
from waypointctl.units import bare_name


class FileModel(BaseModel):
    """A part of a file."""

    model_config = ConfigDict(frozen=True, extra="forbid", field_title_generator=lambda name, _: name)

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
        shared = cls._shared_model()
        return (*cls.model_fields, *cls.bare_names(), *(shared.known_keys() if shared else ()))

    @classmethod
    def renamed(cls, key: str) -> str | None:
        """Return what a key of an earlier version is called now, None where it is not one."""
        shared = cls._shared_model()
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
        model = cls._shared_model()
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
    def _shared_model(cls) -> type[FileModel] | None:
        if not cls.keys_for_each:
            return None
        model = cls.model_fields[cls.keys_for_each[0]].annotation
        assert isinstance(model, type)
        assert issubclass(model, FileModel)
        return model

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Describe every spelling that `_from_file` reads."""
        from waypointctl.mission.file_schema import describe_spellings

        schema = handler.resolve_ref_schema(handler(core))
        describe_spellings(cls, schema, handler)
        return schema


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
