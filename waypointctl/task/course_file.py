"""Courses as files have them: recipes and suites."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal, Self, TypeAlias

from pydantic import Field, Strict, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Position
from waypointctl.mission.quantity import Quantity
from waypointctl.task.course import PERIMETERS, Course
from waypointctl.units import bare_name

Length: TypeAlias = Annotated[float, Quantity("m", gt=0, le=10_000)]
Distance: TypeAlias = Annotated[float, Quantity("m", ge=0, le=10_000)]


class Point(FileModel):
    """A waypoint of a course that is given. A bare [x, y] is its position."""

    list_stands_for: ClassVar[str | None] = "position_m"

    position_m: Position = Field(description="x and y in the world frame")


class CourseFields(FileModel):
    """How the waypoints of an episode are drawn."""

    perimeter: Literal["square", "disc", "ring", "legs", "none"] = Field(
        "square",
        description="square, disc, ring: each waypoint in one, evenly over its area; legs: each at a random distance "
        "and bearing from the last, the first from the robot, so that there is no perimeter; none: another word for it",
    )
    count: Annotated[int, Strict(), Field(gt=0, le=65_536)] = Field(4, description="waypoints, the paper's M")
    centre_m: Position = Field((10.0, 10.0), description="of the square, disc or ring")
    side_m: Length = Field(5.0, description="of the square")
    radius_m: Length = Field(2.5, description="of the disc, and the outer one of the ring")
    inner_radius_m: Length | None = Field(None, description="of the ring, which needs it")
    leg_m: tuple[Length, Length] = Field((1.0, 12.0), description="the shortest and the longest leg")
    min_distance_m: Distance = Field(
        0.0,
        description="no waypoint is drawn nearer than this to the one before it, nor the first to the start; at most "
        "half the square's side, or 0.85 of the radius",
    )

    @property
    def course(self) -> Course:
        """What draws the waypoints."""
        return self._drawn(self.min_distance_m)

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield each field that does not go with the others, and why."""
        takes = PERIMETERS[self.perimeter]
        for name in sorted(self.model_fields_set & _DRAWING):
            if name not in takes:
                yield name, f"means nothing with 'perimeter: {self.perimeter}', which is drawn by {self._takes()}"
        if "leg_m" in takes and self.leg_m[0] > self.leg_m[1]:
            yield "leg_m", f"{list(self.leg_m)} is not in order; the shortest leg comes first"
        not_a_ring = list(self._ring_problems()) if self.perimeter == "ring" else []
        yield from not_a_ring
        if self.min_distance_m and "min_distance_m" in takes and not not_a_ring:
            anywhere = self._drawn(0.0)
            if self.min_distance_m > anywhere.largest_min_distance_m:
                yield "min_distance_m", f"{self.min_distance_m:g} m {anywhere.min_distance_rule}"

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        errors = [
            InitErrorDetails(type=PydanticCustomError("course", "{text}", {"text": text}), loc=(name,), input=None)
            for name, text in self.problems()
        ]
        if errors:
            raise ValidationError.from_exception_data("course", errors)
        return self

    def _ring_problems(self) -> Iterator[tuple[str, str]]:
        if self.inner_radius_m is None:
            yield "perimeter", "a ring needs 'inner_radius', too"
        elif self.inner_radius_m >= self.radius_m:
            yield "inner_radius_m", f"{self.inner_radius_m:g} m is not less than the radius of {self.radius_m:g} m"

    def _takes(self) -> str:
        *names, last = (bare_name(name) or name for name in PERIMETERS[self.perimeter])
        return f"{', '.join(names)} and {last}"

    def _drawn(self, min_distance_m: float) -> Course:
        return Course(
            perimeter=self.perimeter,
            count=self.count,
            centre_m=self.centre_m,
            side_m=self.side_m,
            leg_m=self.leg_m,
            radius_m=self.radius_m,
            inner_radius_m=self.inner_radius_m or 0.0,
            min_distance_m=min_distance_m,
        )


_DRAWING = {name for names in PERIMETERS.values() for name in names}
