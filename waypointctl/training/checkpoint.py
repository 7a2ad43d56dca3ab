"""Checkpoints: a bundle that can fly, and all that training needs to go on bit for bit. No pickle.

A checkpoint is taken between an update and the next rollout. It holds weights, optimiser, normaliser, the state of
every robot and of every random stream; what a learning rate or a phase is follows from the step.
"""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from waypointctl.errors import OutputError, RecipeError
from waypointctl.training.export import export_policy
from waypointctl.training.learner import Learner
from waypointctl.training.recipe import RecipeFile

ARRAYS: Final = "training.safetensors"
FACTS: Final = "training.json"
FOLDER: Final = "checkpoints"

Arrays = dict[str, NDArray[Any]]


def save_checkpoint(learner: Learner, recipe_file: RecipeFile, runs: Path, wall_time_s: float) -> Path:
    """Write a checkpoint into the run's folder and return its own folder, which appears whole.

    Raises:
        OutputError: it cannot be written.
    """
    final = runs / FOLDER / f"step-{learner.steps:010d}"
    staging = final.with_name(f".{final.name}.{os.getpid()}.tmp")
    try:
        staging.parent.mkdir(parents=True, exist_ok=True)
        export_policy(learner, recipe_file, staging, wall_time_s)
        (staging / ARRAYS).write_bytes(save(_arrays(learner)))
        (staging / FACTS).write_text(json.dumps(_facts(learner, recipe_file, wall_time_s)))
        shutil.rmtree(final, ignore_errors=True)
        staging.rename(final)
    except OSError as error:
        raise OutputError(f"the checkpoint cannot be written: {error.strerror}", where=str(final)) from error
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return final


def newest_checkpoint(runs: Path) -> Path:
    """Return the folder of a run's newest checkpoint.

    Raises:
        RecipeError: there is none.
    """
    folders = sorted(path for path in (runs / FOLDER).glob("step-*") if (path / FACTS).is_file())
    if not folders:
        raise RecipeError("no checkpoint to resume from", where=str(runs), mend="Train without --resume.")
    return folders[-1]


def load_checkpoint(learner: Learner, recipe_file: RecipeFile, folder: Path) -> float:
    """Put a fresh learner where a checkpoint was taken; return the wall time spent until then [s].

    Raises:
        RecipeError: the checkpoint is damaged, or of another recipe.
    """
    try:
        facts = json.loads((folder / FACTS).read_text())
        arrays = load((folder / ARRAYS).read_bytes())
    except (OSError, ValueError, SafetensorError) as error:
        raise RecipeError(f"the checkpoint cannot be read: {error}", where=str(folder)) from error
    if facts["recipe_sha256"] != recipe_file.sha256 or facts["total_steps"] != recipe_file.recipe.total_steps:
        mend = "Resume with the recipe, seed and steps that the run began with, or train anew."
        raise RecipeError("the checkpoint was made by another recipe", where=str(folder), mend=mend)
    _restore_learner(learner, arrays, facts)
    _restore_env(learner, arrays, facts)
    _restore_random(arrays, facts)
    return float(facts["wall_time_s"])


def _arrays(learner: Learner) -> Arrays:
    ppo, env, statistics = learner.ppo, learner.env, learner.normaliser.obs_rms
    arrays: Arrays = {f"policy.{name}": value.numpy() for name, value in ppo.policy.state_dict().items()}
    for index, state in ppo.policy.optimizer.state_dict()["state"].items():
        arrays |= {f"optimiser.{index}.{name}": value.numpy() for name, value in state.items()}
    arrays |= {"normaliser.mean": statistics.mean, "normaliser.var": statistics.var}
    arrays |= {"learner.last_obs": _present(ppo._last_obs), "learner.starts": _present(ppo._last_episode_starts)}
    arrays |= {f"progress.{name}": getattr(env.progress, name) for name in _PROGRESS}
    arrays |= {"env.integration": env.batch.integration, "env.noise": env.noise}
    arrays |= {"random.torch": torch.get_rng_state().numpy(), "random.numpy": _legacy_state()["state"]["key"]}
    return {name: np.ascontiguousarray(array) for name, array in arrays.items()}


_PROGRESS: Final = ("waypoints", "count", "index", "steps", "deadline")


def _facts(learner: Learner, recipe_file: RecipeFile, wall_time_s: float) -> dict[str, Any]:
    legacy = _legacy_state()
    return {
        "recipe_sha256": recipe_file.sha256,
        "total_steps": learner.recipe.total_steps,
        "steps": learner.steps,
        "updates": learner.ppo._n_updates,
        "wall_time_s": wall_time_s,
        "normaliser_count": float(learner.normaliser.obs_rms.count),
        "random_numpy": {
            "pos": legacy["state"]["pos"],
            "has_gauss": legacy["has_gauss"],
            "gauss": legacy["gauss"],
        },
        "random_starts": [rng.bit_generator.state for rng in learner.env.starts],
        "random_courses": [rng.bit_generator.state for rng in learner.env.courses],
    }


def _restore_learner(learner: Learner, arrays: Arrays, facts: dict[str, Any]) -> None:
    ppo, statistics = learner.ppo, learner.normaliser.obs_rms
    parts = _section(arrays, "policy")
    ppo.policy.load_state_dict({name: torch.from_numpy(array) for name, array in parts.items()})
    optimiser = ppo.policy.optimizer.state_dict()
    moments: dict[int, dict[str, torch.Tensor]] = {}
    for name, array in _section(arrays, "optimiser").items():
        index, _, kind = name.partition(".")
        moments.setdefault(int(index), {})[kind] = torch.from_numpy(array)
    ppo.policy.optimizer.load_state_dict(optimiser | {"state": moments})
    statistics.mean, statistics.var = arrays["normaliser.mean"], arrays["normaliser.var"]
    statistics.count = facts["normaliser_count"]
    ppo._last_obs, ppo._last_episode_starts = arrays["learner.last_obs"], arrays["learner.starts"]
    ppo.num_timesteps, ppo._n_updates = facts["steps"], facts["updates"]


def _restore_env(learner: Learner, arrays: Arrays, facts: dict[str, Any]) -> None:
    env = learner.env
    env.batch.integration[:] = arrays["env.integration"]
    env.noise[:] = arrays["env.noise"]
    for name in _PROGRESS:
        getattr(env.progress, name)[:] = arrays[f"progress.{name}"]
    for streams, states in ((env.starts, facts["random_starts"]), (env.courses, facts["random_courses"])):
        for rng, state in zip(streams, states, strict=True):
            rng.bit_generator.state = state


def _restore_random(arrays: Arrays, facts: dict[str, Any]) -> None:
    torch.set_rng_state(torch.from_numpy(arrays["random.torch"]))
    legacy = facts["random_numpy"]
    # Stable-baselines3 shuffles minibatches with numpy's global generator.
    np.random.set_state(  # noqa: NPY002
        ("MT19937", arrays["random.numpy"], legacy["pos"], legacy["has_gauss"], legacy["gauss"])
    )


def _legacy_state() -> dict[str, Any]:
    state = np.random.get_state(legacy=False)  # noqa: NPY002 - the generator that stable-baselines3 uses
    assert isinstance(state, dict)
    return state


def _section(arrays: Arrays, name: str) -> Arrays:
    return {key.removeprefix(f"{name}."): array for key, array in arrays.items() if key.startswith(f"{name}.")}


def _present(value: Any) -> NDArray[Any]:
    assert isinstance(value, np.ndarray)
    return value
