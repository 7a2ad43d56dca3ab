"""Where the waypoints of an episode come from, and how long it may take."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from typing import Annotated, ClassVar, Final, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, ValidationError, field_validator, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.errors import InputError
from waypointctl.mission.fields import DAY_S, Position
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.units import bare_name

FloatArray: TypeAlias = NDArray[np.float64]
Length: TypeAlias = Annotated[float, Quantity("m", gt=0, le=10_000)]
Distance: TypeAlias = Annotated[float, Quantity("m", ge=0, le=10_000)]

# The perimeters, each with the fields of a Course that it is drawn by.
PERIMETERS: Final = {
    "square": ("count", "centre_m", "side_m", "min_distance_m"),
    "disc": ("count", "centre_m", "radius_m", "min_distance_m"),
    "ring": ("count", "centre_m", "inner_radius_m", "radius_m", "min_distance_m"),
    "legs": ("count", "leg_m"),
}

# Each try succeeds with a probability of at least 1/5 (largest_gap_m), so the last try is never needed in practice.
_TRIES: Final = 1000


class Deadline(FileModel):
    """How long an episode may take, as in the paper's Algorithm 1."""

    first_s: Annotated[float, Quantity("s", gt=0, le=DAY_S)] = Field(10.0, description="to reach the first waypoint")
    further_s: Annotated[float, Quantity("s", ge=0, le=DAY_S)] = Field(
        20.0, description="added for each waypoint reached"
    )


class Point(FileModel):
    """A waypoint of a given course. A bare [x, y] is its position."""

    list_shorthand: ClassVar[str | None] = "position_m"

    position_m: Position = Field(description="x and y in the world frame")


class GivenCourse(FileModel):
    """A given course. A bare list is its waypoints."""

    list_shorthand: ClassVar[str | None] = "waypoints"

    waypoints: Annotated[tuple[Point, ...], Field(min_length=1, max_length=1000)] = Field(
        description="in the order in which they are to be reached"
    )
    weight: Annotated[float, Strict(), Field(gt=0, le=1000, allow_inf_nan=False)] = Field(
        1.0, description="how often the course is drawn, relative to the others"
    )


class Course(FileModel):
    """How the waypoints of an episode are drawn: in a perimeter, or from a list of courses."""

    perimeter: Literal["square", "disc", "ring", "legs"] = Field(
        "square",
        description="square, disc, ring: each waypoint in one, uniformly over its area; legs: each at a random "
        "distance and bearing from the one before, the first from the robot, without a perimeter",
    )
    count: Annotated[int, Strict(), Field(gt=0, le=65_536)] = Field(4, description="waypoints, the paper's M")
    centre_m: Position = Field((10.0, 10.0), description="of the square, disc or ring")
    side_m: Length = Field(5.0, description="of the square")
    radius_m: Length = Field(2.5, description="of the disc; outer radius of the ring")
    inner_radius_m: Length | None = Field(None, description="of the ring; required there")
    leg_m: tuple[Length, Length] = Field((1.0, 12.0), description="the shortest and the longest leg")
    min_distance_m: Distance = Field(
        0.0,
        description="least distance between consecutive waypoints, and from the start to the first; at most "
        "half the square's side, or 0.85 of the radius",
    )
    cases: Annotated[tuple[GivenCourse, ...], Field(min_length=1, max_length=10_000)] | None = Field(
        None, description="courses to choose from, each a list of waypoints, in place of a perimeter"
    )

    @property
    def longest(self) -> int:
        """Waypoints of the longest course that can be drawn."""
        return self.count if self.cases is None else max(len(case.waypoints) for case in self.cases)

    @property
    def region(self) -> Square | Ring | None:
        """Where waypoints are drawn, around the centre; None where they may be anywhere."""
        match self.perimeter:
            case "square":
                return Square(self.side_m)
            case "disc":
                return Ring(0.0, self.radius_m)
            case "ring":
                return Ring(self.inner_radius_m or 0.0, self.radius_m)
        return None

    def draw(self, rng: np.random.Generator, start: FloatArray) -> FloatArray:
        """Return waypoints (m, 2) in the world frame [m] for a robot at start (2,)."""
        if self.cases is not None:
            return _chosen(rng, self.cases)
        region = self.region
        if region is None:
            return self._legs(rng, start)
        if not self.min_distance_m:
            return np.asarray(self.centre_m) + region.draw(rng, self.count)
        return self._apart(rng, start, region)

    def _legs(self, rng: np.random.Generator, start: FloatArray) -> FloatArray:
        length = rng.uniform(*self.leg_m, self.count)
        bearing = rng.uniform(-math.pi, math.pi, self.count)
        legs = np.stack([length * np.cos(bearing), length * np.sin(bearing)], axis=1)
        return start + np.cumsum(legs, axis=0)

    def _apart(self, rng: np.random.Generator, start: FloatArray, region: Square | Ring) -> FloatArray:
        """Draw each waypoint again until it is far enough from the one before."""
        waypoints, before = np.empty((self.count, 2)), start
        for waypoint in waypoints:
            for _ in range(_TRIES):
                waypoint[:] = np.asarray(self.centre_m) + region.draw(rng, 1)[0]
                if math.dist(waypoint, before) >= self.min_distance_m:
                    break
            else:
                raise InputError(f"course.min_distance_m: no waypoint {self.min_distance_m} m from {before} was found")
            before = waypoint
        return waypoints

    @field_validator("cases", mode="before")
    @classmethod
    def _lists_in_lists(cls, cases: object) -> object:
        # The most frequent error is a missing bracket; pydantic's message on it would not name the brackets.
        waypoints = [point for case in _entries(cases) for point in _entries(case)]
        if any(isinstance(part, int | float | str) for part in (*_entries(cases), *waypoints)):
            raise ValueError("each case is a list of waypoints, and each waypoint [x, y]: cases: [[[10 m, 10 m]]]")
        return cases

    @model_validator(mode="after")
    def _fields_agree(self) -> Self:
        errors = [
            InitErrorDetails(type=PydanticCustomError("course", "{text}", {"text": text}), loc=(name,), input=None)
            for name, text in self._problems()
        ]
        if errors:
            raise ValidationError.from_exception_data("course", errors)
        return self

    def _problems(self) -> Iterator[tuple[str, str]]:
        """Yield each field that does not agree with the others, and why."""
        drawing = {name for names in PERIMETERS.values() for name in names}
        if self.cases is not None:
            for name in sorted(self.model_fields_set & {"perimeter", *drawing}):
                yield name, "cannot be used with 'cases', which are the courses themselves: keep one of the two"
            return
        takes = PERIMETERS[self.perimeter]
        for name in sorted((self.model_fields_set & drawing) - set(takes)):
            yield name, f"is not used by 'perimeter: {self.perimeter}', which takes {_listed(takes)}"
        if "leg_m" in takes and self.leg_m[0] > self.leg_m[1]:
            yield "leg_m", f"{list(self.leg_m)} is not in order: the shortest leg comes first"
        if self.perimeter == "ring" and self.inner_radius_m is None:
            yield "perimeter", "a ring also needs 'inner_radius'"
        elif self.perimeter == "ring" and self.inner_radius_m and self.inner_radius_m >= self.radius_m:
            yield "inner_radius_m", f"{self.inner_radius_m:g} m is not less than the radius of {self.radius_m:g} m"
        elif (region := self.region) is not None and self.min_distance_m > region.largest_gap_m:
            most = f"{region.largest_gap_m:g} m ({region.gap_rule})"
            yield "min_distance_m", f"{self.min_distance_m:g} m is not from 0 to {most}, the most in this region"


@dataclass(frozen=True, slots=True)
class Square:
    """A square around its centre: the paper's perimeter. side_m: its side [m]."""

    gap_rule: ClassVar[str] = "half its side"

    side_m: float

    @property
    def largest_gap_m(self) -> float:
        """The distance [m] beyond which, from any point of the plane, at least 1/5 of the area remains."""
        return self.side_m / 2

    def draw(self, rng: np.random.Generator, count: int) -> FloatArray:
        """Return points (count, 2) around the centre [m], uniformly over the area."""
        half = self.side_m / 2
        return rng.uniform(-half, half, (count, 2))


@dataclass(frozen=True, slots=True)
class Ring:
    """The area between two concentric circles [m]; with an inner radius of 0, a disc."""

    gap_rule: ClassVar[str] = "0.85 of its radius"

    inner_radius_m: float
    radius_m: float

    @property
    def largest_gap_m(self) -> float:
        """The distance [m] beyond which, from any point of the plane, at least 1/5 of the area remains."""
        return 0.85 * self.radius_m

    def draw(self, rng: np.random.Generator, count: int) -> FloatArray:
        """Return points (count, 2) around the centre [m], uniformly over the area."""
        # The area grows with the square of the radius.
        radius = np.sqrt(rng.uniform(self.inner_radius_m**2, self.radius_m**2, count))
        bearing = rng.uniform(-math.pi, math.pi, count)
        return np.stack([radius * np.cos(bearing), radius * np.sin(bearing)], axis=1)


def _chosen(rng: np.random.Generator, cases: tuple[GivenCourse, ...]) -> FloatArray:
    """Return the waypoints (m, 2) [m] of one course of a list, drawn by the weights."""
    limits = list(accumulate(case.weight for case in cases))
    number = int(np.searchsorted(limits, rng.random() * limits[-1], side="right"))
    # The product can round up to the last limit.
    waypoints = cases[min(number, len(cases) - 1)].waypoints
    return np.array([point.position_m for point in waypoints], np.float64)


def _entries(value: object) -> list[object]:
    return value if isinstance(value, list) else []


def _listed(fields: tuple[str, ...]) -> str:
    *names, last = (bare_name(name) or name for name in fields)
    return f"{', '.join(names)} and {last}"
