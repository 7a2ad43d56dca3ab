"""Checkpoints: a policy bundle, and all that training needs to continue bit for bit. No pickle."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict
from safetensors import SafetensorError
from safetensors.numpy import load, save

from waypointctl.errors import OutputError, RecipeError
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.policy.manifest import StartRecord
from waypointctl.task.plugins import named_plugins, plugin_hashes
from waypointctl.training.export import export_policy
from waypointctl.training.recipe_evaluation import SelectionRecipe
from waypointctl.training.recipe_file import RECIPE, RecipeFile
from waypointctl.training.run_folder import checkpoint_at, require_checkpoint
from waypointctl.training.state import SavedState, StateFacts, TrainingState

ARRAYS: Final = "training.safetensors"
FACTS: Final = "training.json"

_LARGEST: Final = 2**30  # [bytes] of the networks and the state of the optimiser and the robots
_REMOVE: Final = "Remove the folder to continue from the checkpoint before it."


class Facts(BaseModel):
    """The part of a checkpoint that is not an array.

    Attributes:
        recipe_sha256: of the recipe's file.
        seed: of the run, which can differ from the file's.
        phase_steps: the lengths of the phases, which can differ from the file's.
        wall_time_s: spent on training until then.
        selection: of the run, which can differ from the file's.
        start: the policy of the warm start, whose files may be gone.
        robot_sha256: of the files of its folder.
        plugins: the SHA-256 of each file of the recipe's plugins, by its name.
        torch_threads: of the run, on which the weights depend.
        state: of the robots and the learner.
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
    state: StateFacts


def save_checkpoint(state: TrainingState, recipe_file: RecipeFile, run: Path, wall_time_s: float) -> Path:
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
        export_policy(state, recipe_file, staging, wall_time_s)
        saved = state.save()
        arrays = save(saved.arrays)
        facts = _facts(state, recipe_file, wall_time_s, saved.facts)
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
    checkpoint = require_checkpoint(run)
    facts, _ = _read(checkpoint)
    _refuse_other_file(facts, recipe_file, checkpoint)
    recipe = recipe_file.recipe.with_phase_steps(facts.phase_steps)
    began = {"seed": facts.seed, "selection": facts.selection}
    return replace(recipe_file, recipe=recipe.model_copy(update=began))


def load_checkpoint(state: TrainingState, recipe_file: RecipeFile, folder: Path) -> float:
    """Continue a new training from a checkpoint; return the wall time spent until then [s].

    Raises:
        RecipeError: the checkpoint is damaged, or of another recipe, seed, number of steps, robot or plugins.
    """
    facts, arrays = _read(folder)
    _refuse_other_file(facts, recipe_file, folder)
    recipe = recipe_file.recipe
    for what, began, now in (
        ("seed", facts.seed, recipe.seed),
        ("steps", facts.phase_steps, [phase.steps for phase in recipe.phases]),
        ("a robot of SHA-256", facts.robot_sha256, _robot_sha256(state)),
        ("the plugins", named_plugins(facts.plugins), named_plugins(_plugins(state))),
    ):
        if began != now:
            problem = f"the run began with {what} {began}, not {now}"
            raise RecipeError(
                problem, where=str(folder), hint="Resume with the run's options, robot and plugins, or start a new run."
            )
    try:
        state.load(SavedState(load(arrays), facts.state))
    except (KeyError, RuntimeError, ValueError, SafetensorError) as error:
        problem = f"the checkpoint does not fit this version of waypointctl: {error}"
        raise RecipeError(problem, where=str(folder), hint="Resume with the version that wrote it.") from error
    state.start = facts.start
    state.use_torch_threads(facts.torch_threads)
    return facts.wall_time_s


def _facts(state: TrainingState, recipe_file: RecipeFile, wall_time_s: float, facts: StateFacts) -> Facts:
    recipe = recipe_file.recipe
    return Facts(
        recipe_sha256=recipe_file.sha256,
        seed=recipe.seed,
        phase_steps=[phase.steps for phase in recipe.phases],
        wall_time_s=wall_time_s,
        selection=recipe.selection,
        start=state.start,
        robot_sha256=_robot_sha256(state),
        plugins=_plugins(state),
        torch_threads=state.threads.torch,
        state=facts,
    )


def _robot_sha256(state: TrainingState) -> str:
    digest = hashlib.sha256()
    for name, content in sorted(state.env.robot.files.items()):
        digest.update(f"{name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()


def _plugins(state: TrainingState) -> dict[str, str]:
    return plugin_hashes(state.env.config.plugins)


def _sha256(facts: Facts, arrays: bytes) -> str:
    return hashlib.sha256(facts.model_dump_json().encode() + arrays).hexdigest()


def _read(folder: Path) -> tuple[Facts, bytes]:
    try:
        content = json.loads(read_input(folder / FACTS, RECORD_FILE, RecipeError, within=folder))
        arrays = read_input(folder / ARRAYS, _LARGEST, RecipeError, within=folder)
        facts = Facts.model_validate(content["facts"])
        expected = content["sha256"]
    except RecipeError as error:
        problem = f"the checkpoint cannot be read: {Path(str(error.where)).name}: {error.problem}"
        raise RecipeError(problem, where=str(folder), hint=_REMOVE) from error
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        problem = f"the checkpoint is damaged: {FACTS} was changed"
        raise RecipeError(problem, where=str(folder), hint=_REMOVE) from error
    if _sha256(facts, arrays) != expected:
        problem = f"the checkpoint is damaged: {FACTS} and {ARRAYS} were changed"
        raise RecipeError(problem, where=str(folder), hint=_REMOVE)
    return facts, arrays


def _refuse_other_file(facts: Facts, recipe_file: RecipeFile, folder: Path) -> None:
    if facts.recipe_sha256 != recipe_file.sha256:
        hint = f"Resume with {folder.parents[1] / RECIPE}, the recipe as it was when the run began, or start a new run."
        raise RecipeError(
            f"the checkpoint was made by another recipe than {recipe_file.path}", where=str(folder), hint=hint
        )
