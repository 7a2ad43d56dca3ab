"""The paths of a suite: one that is given, or how random ones are drawn."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Name, Position
from waypointctl.seeding import stream
from waypointctl.task.course import Course, Point

FloatArray: TypeAlias = NDArray[np.float64]
Rate: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1)]


class Case(FileModel):
    """One path, the same in every trial."""

    name: Name
    waypoints: Annotated[tuple[Point, ...], Field(min_length=1, max_length=1000)] = Field(
        description="in the order in which they are to be reached"
    )
    paper: Rate | None = Field(None, description="the published success rate")

    @property
    def path(self) -> tuple[Position, ...]:
        """The waypoints (x, y) [m]."""
        return tuple(point.position_m for point in self.waypoints)

    @property
    def longest(self) -> int:
        """The number of waypoints."""
        return len(self.waypoints)

    def trial_path(self, seed: int, stream_name: str, trial: int, start_m: Position) -> FloatArray:
        """Return the waypoints (m, 2) [m], the same for every trial."""
        return np.array(self.path)


class RandomPaths(Course):
    """Paths that are drawn, another for each trial."""

    name: Name

    def trial_path(self, seed: int, stream_name: str, trial: int, start_m: Position) -> FloatArray:
        """Return the waypoints (m, 2) [m] of one trial, whatever the other trials are."""
        return self.draw(stream(seed, stream_name, trial), np.array(start_m))
