"""The blocks of a recipe: network, phases with their schedules, evaluation, selection; the kinds of number in them."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field, Strict

from waypointctl.mission.file_model import FileModel
from waypointctl.task.reward import RewardWeights

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


class EvaluationRecipe(FileModel):
    """The evaluation that follows training, on the paper's cases."""

    trials: Few = Field(100, description="of each of the paper's cases")
    seed: Annotated[int, Strict(), Field(ge=0)] = 1


class SelectionRecipe(FileModel):
    """Checkpoints are evaluated with deterministic actions; the most successful one becomes the policy."""

    suite: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        "region", description="one that comes with waypointctl, or a YAML file, relative to this one"
    )
    trials: Few = Field(200, description="of each of the suite's cases")
    seed: Annotated[int, Strict(), Field(ge=1, lt=2**32)] = Field(
        1000, description="of the trials; differs from evaluation.seed: the final evaluation must use other trials"
    )
    every: Count = Field(1_000_000, description="control steps between evaluations; the last step is also evaluated")
    stop_at: Rate | None = Field(None, description="end the training when this success rate is reached")
