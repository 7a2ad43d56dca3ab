"""What of a recipe says which checkpoint becomes the policy, and when training has come far enough."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict

from waypointctl.mission.file_model import FileModel
from waypointctl.training.recipe_fields import Count, Few, Rate


class SelectionRecipe(FileModel):
    """Checkpoints are evaluated with deterministic actions; the most successful one becomes the policy."""

    suite: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        "region", description="one that comes with waypointctl, or a YAML file, relative to this one"
    )
    trials: Few = Field(200, description="of each of the suite's cases")
    # 0 was the seed that `waypointctl eval` reported by default in earlier versions.
    seed: Annotated[int, Strict(), Field(ge=1, lt=2**32)] = Field(
        1000, description="of the trials; not evaluation.seed: what is reported must not have been chosen by"
    )
    every: Count = Field(1_000_000, description="control steps between evaluations; the last step has one too")
    stop_at: Rate | None = Field(None, description="end the training when this success rate is reached")
