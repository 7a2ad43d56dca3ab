"""The JSON Schema of a file model: pydantic's schema of the fields, and every other spelling beside it.

Imported when a schema is requested, never when a file is read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import GetJsonSchemaHandler

from waypointctl.mission.wording import unit_of, units_of
from waypointctl.units import NUMBER_PATTERN

if TYPE_CHECKING:
    from waypointctl.mission.file_model import FileModel

Schema = dict[str, Any]


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
