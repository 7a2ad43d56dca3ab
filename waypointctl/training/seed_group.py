"""One recipe trained with several seeds: a folder with a run for each, resumed as a whole.

runs/ant-waypoint-seeds/   the group, named for its recipe: -2, -3, ... where the name is taken
    group.json             the options of its runs
    seed-0/ seed-1/ ...    the runs; each its own bundle's folder too
    curves.csv curves.png  how they went, when all have ended
    seeds.json             their results
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict, ValidationError

from waypointctl.errors import OutputError, RecipeError
from waypointctl.evaluation.result import EVALUATION
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.paths import refuse_unwritable_folder, write_whole
from waypointctl.policy.manifest import MANIFEST
from waypointctl.training.recipe_evaluation import SelectionRecipe
from waypointctl.training.recipe_file import RECIPE, RecipeFile, place_recipe
from waypointctl.training.run_folder import new_run, newest_checkpoint

GROUP: Final = "group.json"


class GroupFile(BaseModel):
    """group.json: what every run of the group does, but for its seed."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    recipe_sha256: str
    phase_steps: list[int]
    selection: SelectionRecipe | None
    threads: int = 0  # requested; 0 is the default


def group_place(name: str, runs: Path, out: Path | None, *, resume: bool) -> Path:
    """Return the folder of a group of the recipe `name`; a new one is made.

    Args:
        name: of the recipe.
        runs: the folder of all runs.
        out: the group's folder, if it is not to be one in `runs`.
        resume: continue a group: `out`, else the one of that name with the latest change.

    Raises:
        RecipeError: there is no group to continue.
        OutputError: a folder cannot be written.
    """
    if out is not None:
        refuse_unwritable_folder(out)
        return out
    refuse_unwritable_folder(runs)
    own = f"{name}-seeds"
    if not resume:
        return new_run(own, runs)
    names = re.compile(rf"{re.escape(own)}(-[0-9]+)?")
    found = [path.parent for path in runs.glob(f"*/{GROUP}") if names.fullmatch(path.parent.name)]
    if not found:
        hint = "Train without --resume, or name a group's folder with --out."
        raise RecipeError(f"no group of seeds of {name!r} to continue", where=str(runs), hint=hint)
    return max(found, key=_last_worked_on)


def _last_worked_on(group: Path) -> int:
    newest = [newest_checkpoint(run) for run in group.glob("seed-*")]
    return max(path.stat().st_mtime_ns for path in (group / GROUP, *newest) if path is not None)


def run_of(group: Path, seed: int) -> Path:
    """Return the folder of a seed's run."""
    return group / f"seed-{seed}"


def is_complete(run: Path) -> bool:
    """Return whether a run has its bundle and its evaluation, which is written last."""
    return (run / EVALUATION).is_file()


def begin_group(recipe_file: RecipeFile, group: Path, seeds: Iterable[int], threads: int = 0) -> None:
    """Write down what a group's runs are to do; none may have begun, nor may the folder be another training's.

    Args:
        recipe_file: the recipe of all runs.
        group: the folder of the runs.
        seeds: a run each.
        threads: requested; 0 is the default.

    Raises:
        OutputError: one has, the folder is of another training or a policy, or it cannot be written.
    """
    if any((group / name).exists() for name in (GROUP, MANIFEST)) or newest_checkpoint(group):
        problem = "has an earlier training or policy, whose recipe would be replaced"
        raise OutputError(problem, where=str(group), hint="Use --resume to continue it, or choose another folder.")
    for run in (run_of(group, seed) for seed in seeds):
        if newest_checkpoint(run) or is_complete(run):
            problem = "has the checkpoints of an earlier training"
            raise OutputError(problem, where=str(run), hint="Use --resume to continue it, or choose another folder.")
    recipe = recipe_file.recipe
    plan = GroupFile(
        recipe_sha256=recipe_file.sha256,
        phase_steps=[phase.steps for phase in recipe.phases],
        selection=recipe.selection,
        threads=threads,
    )
    try:
        group.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder cannot be made: {error.strerror}", where=str(group)) from error
    write_whole(group / GROUP, f"{plan.model_dump_json(indent=2)}\n".encode(), "the plan")
    place_recipe(recipe_file, group)


def group_begun_as(recipe_file: RecipeFile, group: Path) -> tuple[RecipeFile, int]:
    """Return the recipe with the steps and the selection that a group began with, and its number of threads.

    Raises:
        RecipeError: the folder is not a group, or is of another recipe.
    """
    try:
        plan = GroupFile.model_validate_json(read_input(group / GROUP, RECORD_FILE, RecipeError, within=group))
    except (RecipeError, ValidationError) as error:
        problem = f"no group of trainings to continue: no readable {GROUP}"
        raise RecipeError(problem, where=str(group), hint="Train without --resume.") from error
    if plan.recipe_sha256 != recipe_file.sha256:
        hint = f"Resume with {group / RECIPE}, the recipe as it was when the group began, or start a new group."
        raise RecipeError(f"the group was made by another recipe than {recipe_file.path}", where=str(group), hint=hint)
    recipe = recipe_file.recipe.with_phase_steps(plan.phase_steps).model_copy(update={"selection": plan.selection})
    return replace(recipe_file, recipe=recipe), plan.threads
