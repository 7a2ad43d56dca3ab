"""Files that a recipe refers to: robot, selection suite, and the policy whose weights a training begins with.

Before a training, missing files are reported together with everything else that is wrong with the recipe. A recipe that
is only read, such as the copy in a policy's folder, need not have them.
"""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError, PolicyError, RecipeError, SuiteError
from waypointctl.evaluation.suite import BUILT_IN, Suite
from waypointctl.mission.policy_name import is_bare, policies_there_are, policy_folder
from waypointctl.mission.problems import Problem
from waypointctl.mission.yaml_source import as_error, examine, read_source
from waypointctl.mission.yaml_tree import DataPath, Tree, YamlFault, read_tree
from waypointctl.paths import folder_fault
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import WEIGHTS, StartRecord
from waypointctl.robots.load import load_robot, read_description
from waypointctl.task.observation import Layout, layout
from waypointctl.task.plugins import Plugin
from waypointctl.training.events import WarmStarted
from waypointctl.training.learner import Learner
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RecipeFile, own_suite

_SIZES_HINT: Final = (
    "Give the recipe the network and an observation of that policy's sizes, or another policy in warm_start."
)
_SEED_HINT: Final = "Give evaluation another seed: a policy must not be selected and reported on the same trials."


def load_recipe_to_train(path: Path) -> RecipeFile:
    """Read a recipe for a new training.

    Raises:
        RecipeError: the file is missing or not a recipe, or a file that it refers to is missing or does not fit;
            every error is listed with line and column.
    """
    source = read_source(path, RecipeError)
    reading = examine(source, str(path), Recipe)
    problems = [*reading.problems, *_reference_problems(source, path, reading.model)]
    if reading.model is None or problems:
        own = str(path)
        problems.sort(key=lambda one: (one.where != own, one.line, one.column))  # a suite's errors come last
        raise as_error(tuple(problems), RecipeError)
    return RecipeFile(reading.model.read_from(path.parent), source, path)


def _reference_problems(source: bytes, path: Path, recipe: Recipe | None) -> Iterator[Problem]:
    """Yield what is wrong with what the file refers to; `recipe` is None where other things are wrong with the file."""
    try:
        tree = read_tree(source)
    except YamlFault:
        return
    if recipe is not None and not is_bare(recipe.robot):
        yield from _robot_problems(recipe.read_from(path.parent), path, tree)
    if suite := _text_at(tree, ("selection", "suite")):
        yield from _suite_problems(suite, path, tree)
    if warm_start := _text_at(tree, ("warm_start",)):
        for text in _warm_start_faults(warm_start, path.parent, recipe):
            yield _problem(path, tree, ("warm_start",), text)


def _robot_problems(recipe: Recipe, path: Path, tree: Tree) -> Iterator[Problem]:
    try:
        robot = load_robot(recipe.robot_path)
    except InputError as error:
        place = f"{error.where}: " if error.where else ""
        yield _problem(path, tree, ("robot",), f"{place}{error.problem}{_inline(error.hint)}")
        return
    try:
        recipe.domain_randomization.latency_steps(robot)
    except InputError as error:
        yield _problem(path, tree, ("domain_randomization",), error.problem)


def _text_at(tree: Tree, path: DataPath) -> str | None:
    """Return the text at a path of the file; None if it is missing or not a text."""
    data: Any = tree.data
    for part in path:
        data = data.get(part) if isinstance(data, dict) else None
    return data if isinstance(data, str) else None


def _problem(file: Path, tree: Tree, path: DataPath, text: str) -> Problem:
    mark = tree.values[path]
    return Problem(str(file), mark.line, mark.column, ".".join(str(part) for part in path), text)


def _suite_problems(suite: str, recipe: Path, tree: Tree) -> Iterator[Problem]:
    path = ("selection", "suite")
    own = own_suite(suite, recipe)
    if own is None:
        if suite not in BUILT_IN:
            yield _problem(recipe, tree, path, _unknown_suite(suite, BUILT_IN))
        return
    try:
        source = read_source(own, SuiteError)
    except SuiteError as error:
        text = f"{error.where}: {error.problem}; a suite's path is relative to the recipe"
        yield _problem(recipe, tree, path, text)
        return
    yield from examine(source, str(own), Suite).problems


def _unknown_suite(suite: str, known: tuple[str, ...]) -> str:
    if near := difflib.get_close_matches(suite, known, n=1):
        return f"unknown suite {suite!r}; did you mean {near[0]!r}?"
    return f"unknown suite {suite!r}; use {', '.join(known)} or a YAML file, relative to this one"


def _warm_start_faults(named: str, folder_of_recipe: Path, recipe: Recipe | None) -> Iterator[str]:
    folder = policy_folder(named, folder_of_recipe)
    if fault := folder_fault(folder):
        yield f"{folder}: {fault}; a path is relative to this file{_inline(policies_there_are(named))}"
        return
    try:
        policy = load_policy(folder)
    except PolicyError as error:
        yield f"{error.where}: {error.problem}{_inline(error.hint)}"
        return
    for fault, hint in misfits(policy, recipe) if recipe else ():
        yield f"{not_startable(policy, fault)}{_inline(hint)}"


def _inline(hint: str | None) -> str:
    """Return a hint as the end of a sentence."""
    return f"; {hint[0].lower()}{hint[1:].rstrip('.')}" if hint else ""


@dataclass(frozen=True, slots=True)
class WarmStart:
    """The policy that a training begins with, and its weights by name, as `Learner.export` has them."""

    policy: LoadedPolicy
    weights: dict[str, NDArray[np.generic]]

    def apply(self, learner: Learner, recipe_file: RecipeFile) -> WarmStarted:
        """Load the weights into a new learner; return an event that describes them.

        The layout of the observations may be another one, of the same size. Then inputs with the same name keep
        their meaning, and the others have a new one.

        Raises:
            RecipeError: the policy's weights have other names or shapes.
        """
        manifest, own = self.policy.manifest, _layout(recipe_file.recipe, recipe_file.plugins)
        changed = _changed_inputs(manifest.observation.names, own)
        try:
            learner.warm_start(self.weights, other_inputs=bool(changed))
        except ValueError as error:
            raise _refusal(self.policy, str(error), recipe_file, _SIZES_HINT) from error
        return WarmStarted(manifest.name, manifest.observation.layout, own.name, changed)

    def record(self) -> StartRecord:
        """Return the record for the trained policy's manifest."""
        manifest = self.policy.manifest
        return StartRecord(
            policy=manifest.name,
            observation=manifest.observation.layout,
            steps=manifest.training.steps,
            policy_sha256=self.policy.sha256,
            weights_sha256=hashlib.sha256(self.policy.files[WEIGHTS]).hexdigest(),
            selection=manifest.training.selection,
        )


def load_warm_start(recipe_file: RecipeFile) -> WarmStart | None:
    """Return the policy in the recipe's `warm_start`, a folder relative to the recipe or a name; None without one.

    Raises:
        PolicyError: the policy does not exist or is damaged.
        RecipeError: it is of other sizes than the recipe, of another activation or for another robot; its weights are
            not finite numbers; or it was selected with the seed that the recipe's evaluation has.
    """
    if recipe_file.recipe.warm_start is None:
        return None
    folder = policy_folder(recipe_file.recipe.warm_start, recipe_file.path.parent)
    policy = load_policy(folder)
    for fault, hint in misfits(policy, recipe_file.recipe, recipe_file.plugins):
        raise _refusal(policy, fault, recipe_file, hint)
    return WarmStart(policy, _weights(policy.files[WEIGHTS], str(folder / WEIGHTS)))


def misfits(policy: LoadedPolicy, recipe: Recipe, plugins: tuple[Plugin, ...] = ()) -> Iterator[tuple[str, str]]:
    """Yield each thing that keeps a training by the recipe from beginning with the policy, and how to fix it.

    The size of an observation is left out where it depends on plugins that are not given.
    """
    manifest = policy.manifest
    size = manifest.observation.size if recipe.plugins and not plugins else _layout(recipe, plugins).size
    pairs = (
        ("robot is", manifest.robot, read_description(recipe.robot_path).name),
        ("observation size is", manifest.observation.size, size),
        ("hidden layers are", list(manifest.network.hidden_sizes), list(recipe.network.hidden)),
        ("activation is", manifest.network.activation, recipe.network.activation),
    )
    if others := [f"its {what} {theirs}, the recipe's {own}" for what, theirs, own in pairs if theirs != own]:
        yield ", and ".join(others), _SIZES_HINT
    selected, seed = manifest.training.selection, recipe.evaluation.seed
    if selected is not None and selected.seed == seed:
        yield (
            f"it was selected in {selected.suite!r} with seed {seed}, which is also this recipe's evaluation.seed",
            _SEED_HINT,
        )


def not_startable(policy: LoadedPolicy, fault: str) -> str:
    """Return what is wrong with starting from a policy, as a message has it."""
    return f"cannot start from policy {policy.manifest.name!r}: {fault}"


def _refusal(policy: LoadedPolicy, fault: str, recipe_file: RecipeFile, hint: str) -> RecipeError:
    problem = f"warm_start: {not_startable(policy, fault)}"
    return RecipeError(problem, where=recipe_file.place("warm_start"), hint=hint)


def _weights(content: bytes, where: str) -> dict[str, NDArray[np.generic]]:
    from safetensors import SafetensorError  # only in the train extra
    from safetensors.numpy import load

    try:
        arrays: dict[str, NDArray[np.generic]] = load(content)
    except (SafetensorError, KeyError) as error:  # the latter: a type of numbers that numpy does not have, such as fp8
        raise RecipeError(f"the weights cannot be read: {error}", where=where) from error
    for name, array in arrays.items():
        if array.dtype.kind != "f" or not np.isfinite(array).all():
            raise RecipeError(f"the weights cannot be used: {name} is not an array of finite numbers", where=where)
    return arrays


def _layout(recipe: Recipe, plugins: tuple[Plugin, ...]) -> Layout:
    return layout(recipe.observation, load_robot(recipe.robot_path), plugins)


def _changed_inputs(names: tuple[str, ...], own: Layout) -> tuple[tuple[str, str], ...]:
    pairs = zip(names, (name for name, _, _ in own.components), strict=True)
    return tuple((old, new) for old, new in pairs if old != new)
