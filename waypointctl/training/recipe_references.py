"""Files that a recipe refers to: robot, selection suite and warm-start policy.

Before a training, missing files are reported together with everything else that is wrong with the recipe. A recipe that
is only read, such as the copy in a policy's folder, need not have them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from waypointctl.errors import InputError, PolicyError, RecipeError, SuiteError
from waypointctl.mission.policy_name import is_bare
from waypointctl.mission.problems import Problem
from waypointctl.mission.yaml_source import as_error, examine, read_source
from waypointctl.mission.yaml_tree import DataPath, Tree, YamlFault, read_tree
from waypointctl.robots.load import load_robot
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RecipeFile


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


def own_suite(suite: str, recipe: Path) -> Path | None:
    """Return the file of a suite of one's own, None for the name of one that comes with waypointctl: it is bare.

    Args:
        suite: as the recipe's selection has it.
        recipe: the recipe's file; the suite's path is relative to it.
    """
    path = Path(suite)
    return recipe.parent / path if path.suffix or len(path.parts) > 1 else None


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
    from waypointctl.evaluation.suite import BUILT_IN, Suite

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
    import difflib  # 10 ms, only needed for an error

    if near := difflib.get_close_matches(suite, known, n=1):
        return f"unknown suite {suite!r}; did you mean {near[0]!r}?"
    return f"unknown suite {suite!r}; use {', '.join(known)} or a YAML file, relative to this one"


def _warm_start_faults(named: str, folder_of_recipe: Path, recipe: Recipe | None) -> Iterator[str]:
    from waypointctl.mission.policy_name import policies_there_are, policy_folder
    from waypointctl.paths import folder_fault
    from waypointctl.policy.bundle import load_policy
    from waypointctl.training.warm_start import misfits, not_startable

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
