"""The state of a training: robots and learner; saved, continued bit for bit, and exported as a policy.

What a learning rate or a phase is follows from the step.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.metadata import version
from typing import Final

import numpy as np
import torch

from waypointctl.policy.manifest import (
    ActionSpec,
    NetworkSpec,
    ObservationSpec,
    PolicyDescription,
    StartRecord,
    TrainingRecord,
)
from waypointctl.seeding import restore_streams, streams_words
from waypointctl.sim.stepping import default_threads
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.plugins import plugin_hashes
from waypointctl.training.events import Threads
from waypointctl.training.learner import Arrays, SavedState, prefixed, section
from waypointctl.training.recipe_file import RecipeFile

# Layers of 128 gain little from more than one thread, and lose much if other programs run (bench/threads.py).
TORCH_THREADS: Final = 1
PACKAGES: Final = ("waypointctl", "mujoco", "mjbatch", "numpy", "torch", "stable-baselines3")


class TrainingState:
    """The robots and the learner of one training.

    Attributes:
        recipe_file: of the training, with its plugins.
        recipe: what it follows.
        env: the robots.
        learner: the algorithm at work.
        start: the policy whose weights it began with, if any.
        threads: that it is trained with.
    """

    def __init__(self, recipe_file: RecipeFile, threads: int) -> None:
        """Begin a training.

        Args:
            recipe_file: what to follow.
            threads: of physics and of torch; 0 is the default: `default_threads()` of physics, TORCH_THREADS of torch.
        """
        self.threads = Threads(threads or default_threads(), threads or TORCH_THREADS, requested=threads > 0)
        torch.set_num_threads(self.threads.torch)
        self.recipe_file = recipe_file
        self.recipe = recipe = recipe_file.recipe
        self.start: StartRecord | None = None
        task = recipe.task(0, recipe_file.plugins)
        self.env = BatchedWaypointEnv(task, recipe.algorithm.robots, recipe.seed, threads=self.threads.physics)
        self.learner = recipe.algorithm.make_learner(recipe.learner_task(), self.env)

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
        arrays = prefixed("learner", learner.arrays) | prefixed("progress", self._progress())
        arrays |= {"env.integration": env.batch.integration, "env.noise": env.noise, "env.action": env.action}
        arrays |= {"env.starts": streams_words(env.starts), "env.courses": streams_words(env.courses)}
        arrays |= prefixed("randomized", env.randomized.state())
        if env.failed is not None:
            arrays |= prefixed("failed", env.failed.state())
        return SavedState({name: np.ascontiguousarray(array) for name, array in arrays.items()}, learner.facts)

    def load(self, saved: SavedState) -> None:
        """Continue from a state of the same recipe.

        Raises:
            KeyError, RuntimeError, ValueError: it is of another kind of training.
        """
        env, arrays = self.env, saved.arrays
        env.batch.integration[:] = arrays["env.integration"]
        env.noise[:] = arrays["env.noise"]
        env.action[:] = arrays["env.action"]
        restore_streams(env.starts, arrays["env.starts"])
        restore_streams(env.courses, arrays["env.courses"])
        env.randomized.restore(section(arrays, "randomized"))
        if env.failed is not None:
            env.failed.restore(section(arrays, "failed"))
        for name, array in self._progress().items():
            array[:] = arrays[f"progress.{name}"]
        self.learner.load(SavedState(section(arrays, "learner"), saved.facts))

    def description(self, wall_time_s: float) -> PolicyDescription:
        """Return the manifest of the policy as it now is, all but its files."""
        recipe, env = self.recipe, self.env
        return PolicyDescription(
            name=recipe.name,
            robot=env.robot.name,
            control_period_ns=env.robot.control_period_ns,
            observation=ObservationSpec.of(env.layout.name, env.layout.groups, env.layout.components),
            action=ActionSpec(size=env.robot.num_actions, meaning=env.robot.action_meaning, limits=(-1.0, 1.0)),
            network=NetworkSpec(hidden_sizes=recipe.network.hidden, activation=recipe.network.activation),
            reward=recipe.phases[-1].reward.model_dump(),
            training=TrainingRecord(
                algorithm=self.learner.algorithm,
                recipe=recipe.name,
                recipe_sha256=self.recipe_file.sha256,
                seed=recipe.seed,
                steps=self.steps,
                wall_time_s=round(wall_time_s, 1),
                versions=_versions(),
                start=self.start,
            ),
            plugins=plugin_hashes(env.config.plugins),
        )

    def _progress(self) -> Arrays:
        """Return all arrays that the courses keep, by name; the rest follows from the recipe."""
        return {name: value for name, value in vars(self.env.progress).items() if isinstance(value, np.ndarray)}


@cache
def _versions() -> dict[str, str]:
    return {package: version(package) for package in PACKAGES}
