"""The interface between the training loop and the algorithms: the blocks of a recipe that they read, and the learner.

An algorithm is a file in `algorithms/`: a model of the block's keys that makes a learner. It is added to the union in
`algorithms/__init__.py`; no other file names it. What needs torch is imported when the learner is made.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, Strict

from waypointctl.mission.file_model import FileModel
from waypointctl.task.reward import RewardWeights

if TYPE_CHECKING:
    from waypointctl.task.batched import BatchedWaypointEnv, Step

Arrays: TypeAlias = dict[str, NDArray[Any]]


def prefixed(name: str, arrays: Arrays) -> Arrays:
    """Return arrays under names that begin with `name.`."""
    return {f"{name}.{key}": array for key, array in arrays.items()}


def section(arrays: Arrays, name: str) -> Arrays:
    """Return the arrays whose names begin with `name.`, without it."""
    return {key.removeprefix(f"{name}."): array for key, array in arrays.items() if key.startswith(f"{name}.")}


Count: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=10**12)]
Few: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=65_536)]  # of what takes memory
Fraction: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1)]
Rate: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1)]
Factor: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1000, allow_inf_nan=False)]


def _both_ends(value: object) -> object:
    return [value, value] if isinstance(value, int | float) and not isinstance(value, bool) else value


# The value at the beginning and at the end of a phase; a number stands for a constant.
RateSchedule: TypeAlias = Annotated[
    tuple[Rate, Rate], BeforeValidator(_both_ends, json_schema_input_type=Rate | tuple[Rate, Rate])
]
WeightSchedule: TypeAlias = Annotated[
    tuple[Fraction, Fraction], BeforeValidator(_both_ends, json_schema_input_type=Fraction | tuple[Fraction, Fraction])
]


class Schedules(FileModel):
    """Quantities of an algorithm that change along a phase, from the first value to the second, in a straight line."""

    learning_rate: RateSchedule | None = Field(None, description="of the optimiser")
    entropy: WeightSchedule | None = Field(None, description="weight of the entropy bonus")


class NetworkRecipe(FileModel):
    """The policy's network; a value function has one of the same shape."""

    hidden: Annotated[tuple[Few, ...], Field(min_length=1, max_length=12)] = (128, 128, 128)
    activation: Literal["elu", "tanh", "relu"] = "elu"


class PhaseRecipe(Schedules):
    """A phase of the training with its own reward weights, and schedules in place of the algorithm's."""

    steps: Count = Field(description="control steps of all robots together")
    reward: RewardWeights = RewardWeights()


class AlgorithmRecipe(FileModel):
    """What the `algorithm` blocks of all algorithms have; each adds a `name`, its own keys and its schedules."""

    robots: Few = Field(256, description="simulated in parallel")

    @property
    def iteration_steps(self) -> int:
        """Control steps of all robots in one `Learner.collect`."""
        raise NotImplementedError

    @property
    def schedules(self) -> dict[str, tuple[float, float]]:
        """The schedules of a phase that has none of its own, by the names of `Schedules`."""
        return {name: getattr(self, name) for name in Schedules.model_fields if name in type(self).model_fields}

    def make_learner(self, task: LearnerTask, env: BatchedWaypointEnv) -> Learner:
        """Return a learner that has not begun.

        Args:
            task: what the recipe has beside this block.
            env: the robots, not reset yet.
        """
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class LearnerTask:
    """What a learner needs of a recipe beside the block of its algorithm.

    Attributes:
        network: the shape of the policy's network.
        seed: of the training.
        schedules_at: returns the values of the algorithm's schedules at a control step, by name.
    """

    network: NetworkRecipe
    seed: int
    schedules_at: Callable[[int], dict[str, float]]


@dataclass(slots=True)
class Rollout:
    """What the robots did in one or several calls of `Learner.collect`.

    Attributes:
        steps: control steps of all robots.
        reward: sum over these, unscaled.
        episodes: that ended, by success, fall or timeout.
        successes: episodes that reached the last waypoint.
        falls: episodes that ended in a fall.
        timeouts: episodes that ended at their deadline.
        waypoints: reached.
    """

    steps: int = 0
    reward: float = 0.0
    episodes: int = 0
    successes: int = 0
    falls: int = 0
    timeouts: int = 0
    waypoints: int = 0

    def add(self, step: Step) -> None:
        """Count one control step of all robots."""
        successes, falls, ended = int(step.success.sum()), int(step.terminated.sum()), len(step.ended)
        self.steps += len(step.reward)
        self.reward += float(step.reward.sum())
        self.episodes += ended
        self.successes += successes
        self.falls += falls
        self.timeouts += ended - successes - falls
        self.waypoints += int(step.reached.sum())


@dataclass(frozen=True, slots=True)
class SavedState:
    """All that a learner, or a whole training, needs to continue bit for bit: arrays, and the rest as JSON."""

    arrays: Arrays
    facts: dict[str, Any]


@dataclass(frozen=True, slots=True)
class ExportedPolicy:
    """The policy as it is now.

    Attributes:
        onnx: the network, with the normalisation of its observations, for flying.
        weights: everything learnt, by name, for another training to begin with.
    """

    onnx: bytes
    weights: dict[str, NDArray[np.generic]]


class Learner(Protocol):
    """An algorithm at work on the robots of one training.

    `save`, `export` and `load` are called between an update and the next collection alone. A learner draws from random
    streams of its own and from those that its state holds: what it is after `load` decides all that follows.
    """

    algorithm: str  # its name, with the package that it is from, for the manifest

    @property
    def steps(self) -> int:
        """Control steps of all robots so far."""

    def collect(self) -> Rollout:
        """Act on the robots for `AlgorithmRecipe.iteration_steps` control steps, and keep the samples for `update`."""

    def update(self) -> dict[str, float]:
        """Learn; return metrics by name, such as losses and the present values of the schedules.

        Raises:
            ValueError: a number is not finite, so that no update is possible.
        """

    def is_finite(self) -> bool:
        """Return whether all parameters are finite numbers."""

    def save(self) -> SavedState:
        """Return the state; one that has not begun begins its first episodes before."""

    def load(self, state: SavedState) -> None:
        """Continue from a state that a learner of the same recipe saved.

        Raises:
            KeyError, RuntimeError, ValueError: it is of another kind of learner.
        """

    def export(self) -> ExportedPolicy:
        """Return the policy as it is now."""

    def warm_start(self, weights: dict[str, NDArray[np.generic]], *, other_inputs: bool) -> None:
        """Begin with the weights of another policy; the optimiser is new.

        Args:
            weights: as `export` has them.
            other_inputs: some inputs have another meaning here, so that the statistics of the observations must be
                free to change.

        Raises:
            ValueError: the weights have other names or shapes.
        """
