"""Extending another run with a longer recipe; the result is the same as training with that recipe from the start.

A run's folder keeps its recipe, so the common part of two recipes is known: they may differ only in phases at the end.
All checkpoints within the common part are reused. The last one of a complete run is not among them, because its last
update used the learning rate of the shorter recipe.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from waypointctl.errors import OutputError, RecipeError
from waypointctl.input_file import read_input
from waypointctl.paths import write_whole
from waypointctl.training.checkpoint import begun_as, load_checkpoint, save_checkpoint
from waypointctl.training.checkpoint_evaluation import SUITE
from waypointctl.training.progress_file import PROGRESS
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RECIPE, RecipeFile, load_recipe, place_recipe
from waypointctl.training.run_folder import checkpoints
from waypointctl.training.selection import SELECTION
from waypointctl.training.state import TrainingState

_LARGEST: Final = 2**26  # [bytes]
# Keys in which two recipes may differ and train in the same way.
_FREE: Final = ("name", "description", "phases", "checkpoint_steps", "evaluation")


def extend(recipe_file: RecipeFile, source: Path, run: Path, threads: int = 0) -> int:
    """Give a new run the checkpoints that its recipe shares with another run; return the steps it continues from.

    Resumed, with as many threads as `source` had, the run ends in the very weights that it would have ended in,
    trained from nothing.

    Args:
        recipe_file: the longer recipe.
        source: the run to continue; it is not changed.
        run: the new run's folder, without checkpoints.
        threads: of physics and of torch; 0 is the default, or those of the run that is continued.

    Raises:
        RecipeError: `source` is not a run, or its recipe is not the beginning of this one, or it has no checkpoint
            in the part that they share.
        OutputError: `run` cannot be written.
    """
    began, taken = shared_checkpoints(recipe_file, source)
    try:
        run.mkdir(parents=True, exist_ok=True)
        for name in (PROGRESS, SELECTION, SUITE):  # resuming leaves out what is later than the last checkpoint
            if (source / name).exists():
                found = read_input(source / name, _LARGEST, RecipeError, within=source)
                write_whole(run / name, found, "what the run has found")
        place_recipe(recipe_file, run)
    except OSError as error:
        raise OutputError(f"cannot be written: {error.strerror}", where=str(run)) from error
    return max(_take(folder, began, recipe_file, run, threads) for folder in taken)


def shared_checkpoints(recipe_file: RecipeFile, source: Path) -> tuple[RecipeFile, list[Path]]:
    """Return the recipe as the run `source` began, and its checkpoints that a longer recipe shares.

    Raises:
        RecipeError: as `extend`.
    """
    if not checkpoints(source):
        hint = "--extend takes the folder of a run, or its name; a recipe's warm_start begins with a policy's weights."
        raise RecipeError("is not a run: it has no checkpoints", where=str(source), hint=hint)
    began = begun_as(load_recipe(source / RECIPE), source)
    shared = shared_steps(began.recipe, recipe_file.recipe, source)
    taken = [folder for steps, folder in checkpoints(source) if steps < shared]
    if not taken:
        problem = f"has no checkpoint before step {shared}, up to which the two recipes are the same"
        raise RecipeError(problem, where=str(source), hint="Train without --extend.")
    return began, taken


def shared_steps(old: Recipe, new: Recipe, source: Path) -> int:
    """Return up to which control step two recipes train in the same way.

    Raises:
        RecipeError: from the first step on they do not.
    """
    before, after = ({name: value for name, value in recipe if name not in _FREE} for recipe in (old, new))
    different = [name for name in before if before[name] != after[name]]
    steps = 0
    for one, other in zip(old.phases, new.phases, strict=False):
        if one != other:
            break
        steps += one.steps
    if not different and steps == 0:
        different = ["phases[0]"]
    if different:
        problem = f"was trained by a recipe with another {', '.join(different)}"
        hint = f"Only {', '.join(_FREE[:2])}, {', '.join(_FREE[3:])} and phases at the end may differ."
        raise RecipeError(problem, where=str(source), hint=hint)
    return steps


def _take(folder: Path, began: RecipeFile, recipe_file: RecipeFile, run: Path, threads: int) -> int:
    """Write a checkpoint as the longer recipe makes it; return its steps."""
    state = TrainingState(recipe_file.recipe, threads, recipe_file.plugins)
    wall_time_s = load_checkpoint(state, began, folder)
    save_checkpoint(state, recipe_file, run, wall_time_s)
    return state.steps
