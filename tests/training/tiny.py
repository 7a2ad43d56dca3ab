"""A training so small that it takes a second, and one that interrupts itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from safetensors.numpy import load

from waypointctl.training.algorithms.ppo_learner import PpoLearner
from waypointctl.training.recipe_file import RecipeFile, load_recipe
from waypointctl.training.state import TrainingState
from waypointctl.training.train import TrainingResult, train

RECIPE = """\
name: tiny
seed: 7
course: {perimeter: legs, count: 2, leg: [0.6 m, 1 m]}
start: {random_heading: true}
deadline: {first: 0.4 s, further: 0.4 s}
network: {hidden: [16, 16]}
algorithm: {name: ppo, robots: 16, rollout_steps: 8, minibatch: 64, epochs: 2}
phases:
  - {steps: 640, learning_rate: [1.0e-3, 5.0e-4]}
  - {steps: 384, learning_rate: [5.0e-4, 1.0e-4], reward: {alive: 0, fall: 50}}
checkpoint_steps: 256
evaluation: {trials: 1}
"""
ROLLOUT = 128  # control steps of all robots between two updates
ROLLOUTS = 8


def tiny_recipe(folder: Path, text: str = RECIPE) -> RecipeFile:
    """Write the recipe into `folder` and read it."""
    path = folder / "recipe.yaml"
    path.write_text(text)
    return load_recipe(path)


def after(rollouts: int) -> Callable[[], bool]:
    """Return an `interrupted` that is true once it has been asked before that many rollouts."""
    asked = 0

    def interrupted() -> bool:
        nonlocal asked
        asked += 1
        return asked > rollouts

    return interrupted


def trained(recipe_file: RecipeFile, run: Path, *, rollouts: int | None = None, resume: bool = False) -> TrainingResult:
    """Train into the run's folder, on one thread, for some rollouts or to the end."""
    interrupted = (lambda: False) if rollouts is None else after(rollouts)
    return train(recipe_file, run, threads=1, resume=resume, interrupted=interrupted)


def weights_of(folder: Path) -> bytes:
    """Return the bytes of a bundle's weights, which hold every parameter and the normaliser."""
    content = (folder / "weights.safetensors").read_bytes()
    assert all(np.isfinite(array).all() for array in load(content).values())
    return content


def ppo_of(state: TrainingState) -> PpoLearner:
    """Return the learner of a training by the recipe above."""
    assert isinstance(state.learner, PpoLearner)
    return state.learner


def new_state(recipe_file: RecipeFile) -> TrainingState:
    """Return a training that has not begun."""
    return TrainingState(recipe_file, threads=1)
