"""The part of a recipe on learning: network and phases."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from waypointctl.mission.file_model import FileModel
from waypointctl.task.reward import RewardWeights
from waypointctl.training.learner import Schedules
from waypointctl.training.recipe_fields import Count, Few


class NetworkRecipe(FileModel):
    """The policy's network; a value function has one of the same shape."""

    hidden: Annotated[tuple[Few, ...], Field(min_length=1, max_length=12)] = (128, 128, 128)
    activation: Literal["elu", "tanh", "relu"] = "elu"


class PhaseRecipe(Schedules):
    """A phase of the training with its own reward weights, and schedules in place of the algorithm's."""

    steps: Count = Field(description="control steps of all robots together")
    reward: RewardWeights = RewardWeights()
