"""Recipes as YAML files, and the JSON Schema for editors."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from waypointctl.errors import RecipeError
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.mission.yaml_tree import read_tree
from waypointctl.training.recipe import Recipe


@dataclass(frozen=True, slots=True)
class RecipeFile:
    """A recipe and the file that it came from.

    Attributes:
        recipe: what to do; its seed and steps need not be the file's.
        source: the file's bytes.
        path: of the file.
    """

    recipe: Recipe
    source: bytes
    path: Path

    @property
    def sha256(self) -> str:
        """Of the file's bytes."""
        return hashlib.sha256(self.source).hexdigest()

    def place(self, *path: str | int) -> str:
        """Return where the file has something, "file:line:column"; the file alone where it does not have it."""
        mark = read_tree(self.source).values.get(path)
        return f"{self.path}:{mark.line}:{mark.column}" if mark else str(self.path)


def load_recipe(path: Path) -> RecipeFile:
    """Read a recipe.

    Raises:
        RecipeError: there is no such file, or it is not a recipe; everything wrong is listed with line and column.
    """
    source = read_source(path, RecipeError)
    return RecipeFile(read_model(source, str(path), Recipe, RecipeError), source, path)


def recipe_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of a recipe, with every spelling that is read."""
    from waypointctl.mission.file_schema import model_schema

    schema = model_schema(Recipe, "waypointctl recipe")
    _drop_infinite_defaults(schema)
    return schema


def _drop_infinite_defaults(schema: Any) -> None:
    """Leave out, in place, defaults with a number that JSON does not have."""
    if isinstance(schema, list):
        for part in schema:
            _drop_infinite_defaults(part)
    elif isinstance(schema, dict):
        if _has_infinity(schema.get("default")):
            del schema["default"]
        for part in schema.values():
            _drop_infinite_defaults(part)


def _has_infinity(value: Any) -> bool:
    if isinstance(value, dict):
        return any(_has_infinity(part) for part in value.values())
    return isinstance(value, float) and math.isinf(value)
