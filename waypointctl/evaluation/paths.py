"""The paths of a suite: one that is given, or how random ones are drawn."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, model_validator

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Coordinate, Name, Position
from waypointctl.mission.quantity import Quantity
from waypointctl.seeding import stream
from waypointctl.task.course import Course

FloatArray: TypeAlias = NDArray[np.float64]
Rate: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1)]
Length: TypeAlias = Annotated[float, Quantity("m", gt=0, le=10_000)]

_OF_SQUARES = ("centre_m", "side_m")
_OF_LEGS = ("leg_m",)


class Place(FileModel):
    """A waypoint. A bare [x, y] is its position."""

    list_stands_for: ClassVar[str | None] = "position_m"

    position_m: Position = Field(description="x and y in the world frame; the robot starts at the origin")


class Case(FileModel):
    """One path, from the origin through its waypoints, that every trial walks."""

    name: Name
    waypoints: Annotated[tuple[Place, ...], Field(min_length=1, max_length=1000)] = Field(
        description="in the order in which they are to be reached"
    )
    paper: Rate | None = Field(None, description="the published success rate")

    @property
    def path(self) -> tuple[Position, ...]:
        """The waypoints (x, y) [m]."""
        return tuple(place.position_m for place in self.waypoints)

    @property
    def longest(self) -> int:
        """The number of waypoints."""
        return len(self.waypoints)

    def draw(self, seed: int, stream_name: str, trial: int) -> FloatArray:
        """Return the waypoints (m, 2) [m], the same for every trial."""
        return np.array(self.path)


class RandomPaths(FileModel):
    """Paths that are drawn, another for each trial."""

    name: Name
    perimeter: Literal["square", "legs"] = Field(
        "square",
        description="square: each waypoint in a square; legs: each at a random distance and bearing from the last",
    )
    count: Annotated[int, Strict(), Field(gt=0, le=1000)] = Field(4, description="waypoints of a path")
    centre_m: tuple[Coordinate, Coordinate] = Field((10.0, 10.0), description="of the square")
    side_m: Length = Field(5.0, description="of the square")
    leg_m: tuple[Length, Length] = Field((1.0, 12.0), description="the shortest and the longest leg")

    @property
    def longest(self) -> int:
        """The number of waypoints."""
        return self.count

    @property
    def course(self) -> Course:
        """What draws them."""
        return Course(
            perimeter=self.perimeter,
            count=self.count,
            centre_m=self.centre_m,
            side_m=self.side_m,
            leg_m=self.leg_m,
        )

    def draw(self, seed: int, stream_name: str, trial: int) -> FloatArray:
        """Return the waypoints (count, 2) [m] of one trial, whatever the other trials are."""
        return self.course.draw(stream(seed, stream_name, trial), np.zeros(2))

    @model_validator(mode="after")
    def _shortest_first(self) -> RandomPaths:
        if self.leg_m[0] > self.leg_m[1]:
            raise ValueError(f"leg_m {list(self.leg_m)}: the shortest leg comes first")
        return self

    @model_validator(mode="after")
    def _says_nothing_in_vain(self) -> RandomPaths:
        foreign = _OF_LEGS if self.perimeter == "square" else _OF_SQUARES
        if vain := [field for field in foreign if field in self.model_fields_set]:
            raise ValueError(f"{vain[0]} has no effect with 'perimeter: {self.perimeter}'; leave it out")
        return self
