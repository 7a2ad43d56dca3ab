"""Recipes as YAML files, and the training that a policy's recipe states."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from waypointctl.errors import InputError, OutputError, RecipeError, given_path
from waypointctl.evaluation.suite import Training
from waypointctl.mission.policy_name import is_bare
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.mission.yaml_tree import read_tree
from waypointctl.paths import write_whole
from waypointctl.policy.manifest import Manifest
from waypointctl.robots.load import ROBOT_COPY, load_robot
from waypointctl.task.plugins import Plugin, load_plugins
from waypointctl.training.recipe import Recipe, unknown_names
from waypointctl.training.run_folder import PLUGIN_COPIES

RECIPE: Final = "train.yaml"  # in a run's folder and in a policy's
MODULES: Final = ("torch", "stable_baselines3", "gymnasium", "onnx", "safetensors", "tensorboard")


@dataclass(frozen=True, slots=True)
class RecipeFile:
    """A recipe and the file that it came from.

    Attributes:
        recipe: what to do; its seed and steps need not be the file's.
        source: the file's bytes.
        path: of the file.
        plugins: the observation groups and reward terms of the recipe's plugins, once they have been loaded.
    """

    recipe: Recipe
    source: bytes
    path: Path
    plugins: tuple[Plugin, ...] = ()

    @property
    def sha256(self) -> str:
        """Of the file's bytes."""
        return hashlib.sha256(self.source).hexdigest()

    def place(self, *path: str | int) -> str:
        """Return where the file has something, "file:line:column"; the file alone where it does not have it."""
        mark = read_tree(self.source).values.get(path)
        return f"{self.path}:{mark.line}:{mark.column}" if mark else str(self.path)


def load_recipe(path: Path | str) -> RecipeFile:
    """Read a recipe.

    Raises:
        RecipeError: the file is missing or not a recipe; every error is listed with line and column.
        InputError: the argument is not a path.
    """
    path = given_path("path", path, "a recipe file")
    source = read_source(path, RecipeError)
    recipe = read_model(source, str(path), Recipe, RecipeError)
    return RecipeFile(recipe.read_from(path.parent), source, path)


def place_recipe(recipe_file: RecipeFile, folder: Path) -> None:
    """Write a recipe into the folder of a run or a policy, which is made, with copies of a user's robot and plugins.

    Raises:
        OutputError: it cannot be written.
    """
    path, recipe = folder / RECIPE, recipe_file.recipe
    if path.exists() and path.samefile(recipe_file.path):
        return
    files = {} if is_bare(recipe.robot) else load_robot(recipe.robot_path).files
    copies = {RECIPE: recipe_file.source} | {f"{ROBOT_COPY}/{name}": content for name, content in files.items()}
    for plugin in recipe_file.plugins:
        if plugin.source is not None:
            copies[f"{PLUGIN_COPIES}/{plugin.source.name}"] = plugin.source.content
    for name, content in copies.items():
        copy = folder / name
        try:
            copy.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"the folder cannot be made: {error.strerror}", where=str(copy.parent)) from error
        write_whole(copy, content, "the copy")


def own_suite(suite: str, recipe: Path) -> Path | None:
    """Return the file of a suite of one's own, None for the name of one that comes with waypointctl: it is bare.

    Args:
        suite: as the recipe's selection has it.
        recipe: the recipe's file; the suite's path is relative to it.
    """
    path = Path(suite)
    return recipe.parent / path if path.suffix or len(path.parts) > 1 else None


def trained_on(folder: Path, manifest: Manifest) -> Training | None:
    """Return whether a policy was trained on a single point or on waypoints.

    Args:
        folder: the bundle.
        manifest: the bundle's, with the hash of the recipe that made it.

    Returns:
        None where that recipe is not in the folder, was changed, or is not read any more.
    """
    try:
        recipe_file = load_recipe(folder / RECIPE)
    except RecipeError:
        return None
    if recipe_file.sha256 != manifest.training.recipe_sha256:
        return None
    cases = recipe_file.recipe.course.cases
    points = {point.position_m for case in cases or () for point in case.waypoints}
    return "single point" if cases and len(points) == 1 else "waypoints"


def require_packages() -> None:
    """Refuse to train where a package of the extra `train` is missing.

    Raises:
        InputError: naming what is missing and how to install it.
    """
    if missing := [module for module in MODULES if find_spec(module) is None]:
        problem = f"training needs packages that are not installed: {', '.join(missing)}"
        raise InputError(problem, hint='Install them with the train extra: pip install ".[train]" in the checkout.')


def with_plugins(recipe_file: RecipeFile, *, allowed: bool) -> RecipeFile:
    """Return a recipe with its plugins, which are executed.

    Raises:
        RecipeError: it has plugins and they are not allowed, or it names a group or term that none of them defines.
        InputError: a plugin is not there, or fails.
    """
    names = recipe_file.recipe.plugins
    if not names:
        return recipe_file
    if not allowed:
        hint = f"read {'it' if len(names) == 1 else 'them'}, then use --allow-plugins"
        raise RecipeError(f"the recipe executes {', '.join(names)}", where=recipe_file.place("plugins"), hint=hint)
    plugins = load_plugins(recipe_file.recipe.plugin_paths)
    for loc, problem in unknown_names(recipe_file.recipe, plugins):
        raise RecipeError(problem, where=recipe_file.place(*loc))
    return replace(recipe_file, plugins=plugins)


def recipe_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of a recipe, with every spelling that is read."""
    from waypointctl.mission.file_model import model_schema

    schema = model_schema(Recipe, "waypointctl recipe")
    _drop_infinite_defaults(schema)
    return schema


def _drop_infinite_defaults(schema: Any) -> None:
    """Remove, in place, defaults with a number that JSON does not have."""
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
