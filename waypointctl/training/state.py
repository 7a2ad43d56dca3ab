"""The state of a training: robots and learner, saved and continued bit for bit.

What a learning rate or a phase is follows from the step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import torch
from pydantic import BaseModel, ConfigDict

from waypointctl.policy.manifest import StartRecord
from waypointctl.sim.stepping import default_threads
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.plugins import Plugin
from waypointctl.training.events import Threads
from waypointctl.training.learner import Arrays, LearnerState
from waypointctl.training.recipe import Recipe

# Layers of 128 gain little from more than one thread, and lose much if other programs run (bench/threads.py).
TORCH_THREADS: Final = 1


class StateFacts(BaseModel):
    """The part of a saved state that is not an array.

    Attributes:
        learner: the algorithm's own.
        starts: the state of the random stream of each robot's starts.
        courses: the same of its courses.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    learner: dict[str, Any]
    starts: list[dict[str, Any]]
    courses: list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class SavedState:
    """A training's state between an update and the next rollout."""

    arrays: Arrays
    facts: StateFacts


class TrainingState:
    """The robots and the learner of one training.

    Attributes:
        recipe: of the training.
        env: the robots.
        learner: the algorithm at work.
        start: the policy whose weights it began with, if any.
        threads: that it is trained with.
    """

    def __init__(self, recipe: Recipe, threads: int, plugins: tuple[Plugin, ...] = ()) -> None:
        """Begin a training.

        Args:
            recipe: what to follow.
            threads: of physics and of torch; 0 is the default: `default_threads()` of physics, TORCH_THREADS of torch.
            plugins: the recipe's, loaded.
        """
        self.threads = Threads(threads or default_threads(), threads or TORCH_THREADS, requested=threads > 0)
        torch.set_num_threads(self.threads.torch)
        self.recipe = recipe
        self.start: StartRecord | None = None
        self.env = BatchedWaypointEnv(
            recipe.task(0, plugins), recipe.algorithm.robots, recipe.seed, threads=self.threads.physics
        )
        self.learner = recipe.algorithm.make_learner(recipe, self.env)

    @property
    def steps(self) -> int:
        """Control steps of all robots so far."""
        return self.learner.steps

    def use_torch_threads(self, number: int) -> None:
        """Use the network's number of threads that the run began with, unless another number was requested."""
        torch_threads = self.threads.torch if self.threads.requested else number
        self.threads = replace(self.threads, began=number, torch=torch_threads)
        torch.set_num_threads(torch_threads)

    def enter_phase(self) -> None:
        """Apply the reward weights of the current phase."""
        phase, _ = self.recipe.phase_at(self.steps)
        self.env.config = self.recipe.task(phase, self.env.config.plugins)

    def save(self) -> SavedState:
        """Return the state; the training is between an update and the next rollout."""
        learner, env = self.learner.save(), self.env
        arrays = _named("learner", learner.arrays) | _named("progress", self._progress())
        arrays |= {"env.integration": env.batch.integration, "env.noise": env.noise, "env.action": env.action}
        arrays |= _named("randomized", env.randomized.state())
        if env.failed is not None:
            arrays |= _named("failed", env.failed.state())
        facts = StateFacts(
            learner=learner.facts,
            starts=[dict(rng.bit_generator.state) for rng in env.starts],
            courses=[dict(rng.bit_generator.state) for rng in env.courses],
        )
        return SavedState({name: np.ascontiguousarray(array) for name, array in arrays.items()}, facts)

    def load(self, saved: SavedState) -> None:
        """Continue from a state of the same recipe.

        Raises:
            KeyError, RuntimeError, ValueError: it is of another kind of training.
        """
        env, arrays = self.env, saved.arrays
        env.batch.integration[:] = arrays["env.integration"]
        env.noise[:] = arrays["env.noise"]
        env.action[:] = arrays["env.action"]
        env.randomized.restore(_section(arrays, "randomized"))
        if env.failed is not None:
            env.failed.restore(_section(arrays, "failed"))
        for name, array in self._progress().items():
            array[:] = arrays[f"progress.{name}"]
        for streams, states in ((env.starts, saved.facts.starts), (env.courses, saved.facts.courses)):
            for rng, state in zip(streams, states, strict=True):
                rng.bit_generator.state = state
        self.learner.load(LearnerState(_section(arrays, "learner"), saved.facts.learner))

    def _progress(self) -> Arrays:
        """Return all arrays that the courses keep, by name; the rest follows from the recipe."""
        return {name: value for name, value in vars(self.env.progress).items() if isinstance(value, np.ndarray)}


def _named(name: str, arrays: Arrays) -> Arrays:
    return {f"{name}.{key}": array for key, array in arrays.items()}


def _section(arrays: Arrays, name: str) -> Arrays:
    return {key.removeprefix(f"{name}."): array for key, array in arrays.items() if key.startswith(f"{name}.")}
