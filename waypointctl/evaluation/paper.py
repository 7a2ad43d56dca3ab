"""What of a suite says which tables a paper published, and what it found."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Strict

from waypointctl.evaluation.paths import Rate
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Name

Training = Literal["single point", "waypoints"]


class PaperPolicy(FileModel):
    """A policy of the paper: how it was trained and what it sees."""

    number: Annotated[int, Strict(), Field(ge=1, le=1000)]
    training: Training = Field(description="single point: always to one and the same; waypoints: drawn each episode")
    observation: Name = Field(description="the layout: state, state_noise, state_goal")
    paper: dict[Name, Rate] | None = Field(
        None, description="its published success rates by case; where left out, the cases' own"
    )


class PaperTable(FileModel):
    """A table of the paper: with one case it has a row for each policy, with one policy a row for each case."""

    title: Name
    policies: Annotated[tuple[int, ...], Field(min_length=1)] = Field(description="by number")
    cases: Annotated[tuple[Name, ...], Field(min_length=1)] = Field(description="by name")
