"""The part of a recipe on evaluation: selection of a checkpoint, and the final evaluation."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict

from waypointctl.mission.file_model import FileModel
from waypointctl.training.recipe_fields import Count, Few, Rate


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
