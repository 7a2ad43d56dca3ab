"""The interface between the training loop and the algorithms.

An algorithm is one file in `algorithms/`: a model of the block's keys, and a learner. It is added to the union in
`algorithms/__init__.py`; no other file names it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field

from waypointctl.mission.file_model import FileModel
from waypointctl.training.recipe_fields import Few, Fraction, Rate

if TYPE_CHECKING:
    from waypointctl.task.batched import BatchedWaypointEnv, Step
    from waypointctl.training.recipe import Recipe

Arrays: TypeAlias = dict[str, NDArray[Any]]


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

    def make_learner(self, recipe: Recipe, env: BatchedWaypointEnv) -> Learner:
        """Return a learner that has not begun.

        Args:
            recipe: with this block, the network, the phases and the seed.
            env: the robots, not reset yet.
        """
        raise NotImplementedError


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
class LearnerState:
    """All that a learner needs to continue bit for bit: arrays, and the rest as JSON."""

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

    def save(self) -> LearnerState:
        """Return the state; one that has not begun begins its first episodes before."""

    def load(self, state: LearnerState) -> None:
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
