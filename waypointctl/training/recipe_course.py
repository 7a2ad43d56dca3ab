"""What of a recipe says where the robot is to go: course, acceptance, deadline, start."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field, Strict, field_validator

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.task.cases import Cases
from waypointctl.task.course import Course
from waypointctl.task.course_file import CourseFields, Length, Point
from waypointctl.task.retry import Retry
from waypointctl.training.recipe_fields import Duration, Factor, Few, Fraction, Place


class CaseRecipe(FileModel):
    """A course as it is. A bare list is its waypoints."""

    list_stands_for: ClassVar[str | None] = "waypoints"

    waypoints: Annotated[tuple[Point, ...], Field(min_length=1, max_length=1000)] = Field(
        description="in the order in which they are to be reached"
    )
    weight: Factor = Field(1.0, description="how often the course is drawn, relative to the others")


class CourseRecipe(CourseFields):
    """Where the robot is to go in an episode: a course that is drawn, or one of a list."""

    cases: Annotated[tuple[CaseRecipe, ...], Field(min_length=1, max_length=10_000)] | None = Field(
        None, description="courses to choose from, each a list of waypoints, in place of all that draws one"
    )
    retry_failed: Fraction = Field(
        0.0,
        description="how probably an episode walks a course again that failed by a fall or the deadline; the success "
        "that training shows counts these, too",
    )
    retry_memory: Annotated[int, Strict(), Field(gt=0, le=256)] = Field(
        8, description="failed courses that a robot remembers, its latest"
    )
    retry_tries: Few = Field(
        5, description="how often a failed course is tried again before it is forgotten; walked, it is at once"
    )

    @field_validator("cases", mode="before")
    @classmethod
    def _lists_in_lists(cls, cases: object) -> object:
        # A bracket too few is the likely mistake, and would be called a number that is no mapping.
        waypoints = [point for case in _entries(cases) for point in _entries(case)]
        if any(isinstance(part, int | float | str) for part in (*_entries(cases), *waypoints)):
            raise ValueError("each case is a list of waypoints, and each waypoint [x, y]: cases: [[[10 m, 10 m]]]")
        return cases

    @property
    def source(self) -> Course | Cases:
        """Where courses come from."""
        if self.cases is None:
            return self.course
        courses = tuple(tuple(point.position_m for point in case.waypoints) for case in self.cases)
        return Cases(courses, tuple(case.weight for case in self.cases))

    @property
    def retry(self) -> Retry:
        """How failed courses are walked again."""
        return Retry(self.retry_failed, self.retry_memory, self.retry_tries)

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield each field that does not go with the others, and why."""
        if self.cases is None:
            yield from super().problems()
        else:
            for name in sorted(self.model_fields_set & set(CourseFields.model_fields)):
                yield name, "means nothing beside 'cases', which are the courses themselves: keep one of the two"
        for name in ("retry_memory", "retry_tries"):
            if name in self.model_fields_set and not self.retry_failed:
                yield name, "means nothing without 'retry_failed', such as retry_failed: 0.3"


def _entries(value: object) -> list[object]:
    return value if isinstance(value, list) else []


class AcceptanceRecipe(FileModel):
    """When a waypoint counts as reached."""

    shape: Literal["box", "radius"] = "box"
    size_m: Length = Field(0.5, description="half the box's side, or the radius")


class DeadlineRecipe(FileModel):
    """How long an episode may take, as in the paper's Algorithm 1."""

    first_s: Duration = Field(10.0, description="to reach the first waypoint")
    further_s: Duration = Field(20.0, description="added for each waypoint reached")


class StartRecipe(FileModel):
    """How the robot stands when an episode begins."""

    position_m: tuple[Place, Place] = (0.0, 0.0)
    heading: Literal["random", "along_x"] = "along_x"
    joint_spread_rad: Annotated[float, Quantity("rad", ge=0, le=1)] = 0.1
    speed_spread: Annotated[float, Strict(), Field(ge=0, le=5)] = Field(0.1, description="in m/s and rad/s")
