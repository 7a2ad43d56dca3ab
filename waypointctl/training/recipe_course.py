"""What of a recipe says where the robot is to go: course, acceptance, deadline, start."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.training.recipe_fields import Duration, Few, Length, Place


class CourseRecipe(FileModel):
    """Where the waypoints of an episode are drawn."""

    perimeter: Literal["square", "legs"] = Field(
        "square", description="square: each in a square; legs: each at a random distance and bearing from the last"
    )
    count: Few = Field(4, description="waypoints an episode, the paper's M")
    centre_m: tuple[Place, Place] = Field((10.0, 10.0), description="of the square")
    side_m: Length = Field(5.0, description="of the square")
    leg_m: tuple[Length, Length] = Field((1.0, 12.0), description="the shortest and the longest leg")

    @model_validator(mode="after")
    def _shortest_first(self) -> CourseRecipe:
        if self.leg_m[0] > self.leg_m[1]:
            raise ValueError(f"leg_m {list(self.leg_m)}: the shortest leg comes first")
        return self


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
