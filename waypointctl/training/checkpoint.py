"""Checkpoints: a policy bundle, and all that training needs to continue bit for bit. No pickle.

A longer recipe, with more phases at the end, reuses the checkpoints of the common part. The last one of a complete run
is not among them, because its last update used the learning rate of the shorter recipe.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ConfigDict
from safetensors import SafetensorError
from safetensors.numpy import load, save

from waypointctl.errors import OutputError, RecipeError
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.paths import write_whole
from waypointctl.policy.manifest import StartRecord
from waypointctl.policy.write import write_bundle
from waypointctl.task.plugins import named_plugins, plugin_hashes
from waypointctl.training.evaluator import SUITE
from waypointctl.training.learner import SavedState
from waypointctl.training.progress import PROGRESS
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RECIPE, RecipeFile, load_recipe, place_recipe
from waypointctl.training.run_folder import checkpoint_at, checkpoints, require_checkpoint
from waypointctl.training.selection import SELECTION, SelectionRecipe
from waypointctl.training.state import TrainingState

ARRAYS: Final = "training.safetensors"
FACTS: Final = "training.json"

_LARGEST: Final = 2**30  # [bytes] of the networks and the state of the optimiser and the robots
_REMOVE: Final = "Remove the folder to continue from the checkpoint before it."
# Keys in which two recipes may differ and train in the same way.
_FREE: Final = ("name", "description", "phases", "checkpoint_steps", "evaluation")


class Facts(BaseModel):
    """The part of a checkpoint that is not an array.

    Attributes:
        recipe_sha256: of the recipe's file.
        seed, phase_steps, selection: of the run, which can differ from the file's.
        wall_time_s: spent on training until then.
        start: the policy of the warm start, whose files may be gone.
        robot_sha256: of the files of its folder.
        plugins: the SHA-256 of each file of the recipe's plugins, by its name.
        torch_threads: of the run, on which the weights depend.
        learner: the algorithm's own.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    recipe_sha256: str
    seed: int
    phase_steps: list[int]
    wall_time_s: float
    selection: SelectionRecipe | None
    start: StartRecord | None
    robot_sha256: str
    plugins: dict[str, str]
    torch_threads: int
    learner: dict[str, Any]


def save_checkpoint(state: TrainingState, run: Path, wall_time_s: float) -> Path:
    """Write a checkpoint into the run's folder and return its own folder, which appears whole.

    A checkpoint of this step that is there already was taken of the very same state, and stays.

    Raises:
        OutputError: it cannot be written.
    """
    final = checkpoint_at(run, state.steps)
    if final.exists():
        return final
    staging = final.with_name(f".{final.name}.{os.getpid()}.tmp")
    try:
        staging.parent.mkdir(parents=True, exist_ok=True)
        exported = state.learner.export()
        write_bundle(staging, state.description(wall_time_s), exported.onnx, save(exported.weights))
        saved = state.save()
        arrays, facts = save(saved.arrays), _facts(state, wall_time_s, saved.facts)
        (staging / ARRAYS).write_bytes(arrays)
        text = json.dumps({"sha256": _sha256(facts, arrays), "facts": facts.model_dump(mode="json")})
        (staging / FACTS).write_text(text, encoding="utf-8")
        staging.rename(final)
    except OSError as error:
        raise OutputError(f"the checkpoint cannot be written: {error.strerror}", where=str(final)) from error
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return final


def begun_as(recipe_file: RecipeFile, run: Path) -> RecipeFile:
    """Return the recipe with the seed, the steps and the selection that a run began with.

    Raises:
        RecipeError: the run has no checkpoint, or its newest is damaged or of another recipe.
    """
    facts, _ = _read(require_checkpoint(run), recipe_file)
    began = {"seed": facts.seed, "selection": facts.selection}
    recipe = recipe_file.recipe.with_phase_steps(facts.phase_steps).model_copy(update=began)
    return replace(recipe_file, recipe=recipe)


def load_checkpoint(state: TrainingState, folder: Path, began: RecipeFile | None = None) -> float:
    """Continue a new training from a checkpoint; return the wall time spent until then [s].

    Args:
        state: that has not begun.
        folder: of the checkpoint.
        began: the recipe that made it; None: that of the state.

    Raises:
        RecipeError: the checkpoint is damaged, or of another recipe, seed, number of steps, robot or plugins.
    """
    recipe_file = began or state.recipe_file
    facts, arrays = _read(folder, recipe_file)
    own, recipe = _facts(state, 0.0, {}), recipe_file.recipe
    for what, before, now in (
        ("seed", facts.seed, recipe.seed),
        ("steps", facts.phase_steps, [phase.steps for phase in recipe.phases]),
        ("a robot of SHA-256", facts.robot_sha256, own.robot_sha256),
        ("the plugins", named_plugins(facts.plugins), named_plugins(own.plugins)),
    ):
        if before != now:
            hint = "Resume with the run's options, robot and plugins, or start a new run."
            raise RecipeError(f"the run began with {what} {before}, not {now}", where=str(folder), hint=hint)
    try:
        state.load(SavedState(load(arrays), facts.learner))
    except (KeyError, RuntimeError, ValueError, SafetensorError) as error:
        problem = f"the checkpoint does not fit this version of waypointctl: {error}"
        raise RecipeError(problem, where=str(folder), hint="Resume with the version that wrote it.") from error
    state.start = facts.start
    state.use_torch_threads(facts.torch_threads)
    return facts.wall_time_s


def _facts(state: TrainingState, wall_time_s: float, learner: dict[str, Any]) -> Facts:
    recipe, robot = state.recipe, hashlib.sha256()
    for name, content in sorted(state.env.robot.files.items()):
        robot.update(f"{name}\0{len(content)}\0".encode() + content)
    return Facts(
        recipe_sha256=state.recipe_file.sha256,
        seed=recipe.seed,
        phase_steps=[phase.steps for phase in recipe.phases],
        wall_time_s=wall_time_s,
        selection=recipe.selection,
        start=state.start,
        robot_sha256=robot.hexdigest(),
        plugins=plugin_hashes(state.env.config.plugins),
        torch_threads=state.threads.torch,
        learner=learner,
    )


def _sha256(facts: Facts, arrays: bytes) -> str:
    return hashlib.sha256(facts.model_dump_json().encode() + arrays).hexdigest()


def _read(folder: Path, recipe_file: RecipeFile) -> tuple[Facts, bytes]:
    try:
        content = json.loads(read_input(folder / FACTS, RECORD_FILE, RecipeError, within=folder))
        arrays = read_input(folder / ARRAYS, _LARGEST, RecipeError, within=folder)
        facts = Facts.model_validate(content["facts"])
        expected = content["sha256"]
        fault = "" if _sha256(facts, arrays) == expected else f"is damaged: {FACTS} or {ARRAYS} was changed"
    except RecipeError as error:
        fault = f"cannot be read: {Path(str(error.where)).name}: {error.problem}"
    except (KeyError, TypeError, ValueError, RecursionError):
        fault = f"is damaged: {FACTS} was changed"
    if fault:
        raise RecipeError(f"the checkpoint {fault}", where=str(folder), hint=_REMOVE)
    if facts.recipe_sha256 != recipe_file.sha256:
        fault = f"the checkpoint was made by another recipe than {recipe_file.path}"
        hint = f"Resume with {folder.parents[1] / RECIPE}, the recipe as it was when the run began, or start a new run."
        raise RecipeError(fault, where=str(folder), hint=hint)
    return facts, arrays


def extend(recipe_file: RecipeFile, source: Path, run: Path, threads: int = 0) -> int:
    """Give a new run the checkpoints that its recipe shares with another run; return the steps it continues from.

    Resumed with as many threads as `source`, the run ends in the weights of a training from nothing, bit for bit.

    Args:
        recipe_file: the longer recipe.
        source: the run to continue; it is not changed.
        run: the new run's folder, without checkpoints.
        threads: of physics and of torch; 0 is the default, or those of the run that is continued.

    Raises:
        RecipeError: as for `shared_checkpoints`.
        OutputError: `run` cannot be written.
    """
    began, taken = shared_checkpoints(recipe_file, source)
    place_recipe(recipe_file, run)
    for name in (PROGRESS, SELECTION, SUITE):  # resuming leaves out what is later than the last checkpoint
        if (source / name).exists():
            found = read_input(source / name, _LARGEST, RecipeError, within=source)
            write_whole(run / name, found, "what the run has found")
    for folder in taken:
        state = TrainingState(recipe_file, threads)
        save_checkpoint(state, run, load_checkpoint(state, folder, began))
    return state.steps


def shared_checkpoints(recipe_file: RecipeFile, source: Path) -> tuple[RecipeFile, list[Path]]:
    """Return the recipe as the run `source` began, and its checkpoints that a longer recipe shares, oldest first.

    Raises:
        RecipeError: `source` is not a run, its recipe is not the beginning of this one, or they share no checkpoint.
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
    same = takewhile(lambda phases: phases[0] == phases[1], zip(old.phases, new.phases, strict=False))
    steps = sum(phase.steps for phase, _ in same)
    different = [name for name in before if before[name] != after[name]] or ([] if steps else ["phases[0]"])
    if different:
        problem = f"was trained by a recipe with another {', '.join(different)}"
        hint = f"Only {', '.join(_FREE[:2])}, {', '.join(_FREE[3:])} and phases at the end may differ."
        raise RecipeError(problem, where=str(source), hint=hint)
    return steps
