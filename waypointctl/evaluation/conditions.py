"""What of a suite says how a trial begins, and when it counts as a success."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import Field, ValidationError

from waypointctl.errors import InputError
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import DAY_S, Hold, Timeout, Tolerance  # a suite's bounds are a mission's
from waypointctl.mission.quantity import Quantity
from waypointctl.task.acceptance import Acceptance
from waypointctl.task.course import Deadline
from waypointctl.task.start import Start
from waypointctl.units import NUMBER_PATTERN


class AcceptanceSpec(FileModel):
    """The region around a waypoint that counts as having reached it."""

    shape: Literal["box", "radius"] = Field("box", description="box: |dx| and |dy| within the size; radius: distance")
    size_m: Tolerance = Field(0.5, description="half the box's side, or the radius")

    def __str__(self) -> str:
        """Return it for people: "box 0.5 m"."""
        return f"{self.shape} {self.size_m:g} m"

    def to_task(self) -> Acceptance:
        """Return it as the task takes it."""
        return Acceptance(self.shape, self.size_m)


def parse_acceptance(text: str) -> AcceptanceSpec:
    """Read an acceptance region as a command line has it: "radius:0.2", "box:0.5" or "box:50cm"; a bare number is in m.

    Raises:
        InputError: it is none.
    """
    shape, _, size = text.partition(":")
    spelling = "size_m" if re.fullmatch(NUMBER_PATTERN, size.strip()) else "size"
    try:
        value = float(size) if spelling == "size_m" else size
        return AcceptanceSpec.model_validate({"shape": shape.strip(), spelling: value})
    except ValidationError as error:
        problem = f"{text!r} is not an acceptance region: a shape, box or radius, and a size up to 100 m"
        raise InputError(problem, where="--acceptance", hint="such as radius:0.2 or box:50cm") from error


class DeadlineSpec(FileModel):
    """How long a trial may take, as in the paper's Algorithm 1."""

    first_s: Timeout = Field(10.0, description="to reach the first waypoint")
    further_s: Hold = Field(20.0, description="added for each waypoint reached")

    def to_task(self) -> Deadline:
        """Return it as the task takes it."""
        return Deadline(self.first_s, self.further_s)


class StartSpec(FileModel):
    """How the robot stands when a trial begins: at the origin, its joints a little off the stance."""

    heading: Literal["random", "along_x"] = "along_x"

    def to_task(self) -> Start:
        """Return it as the task takes it."""
        return Start(heading_rad=None if self.heading == "random" else 0.0)


class HoldSpec(FileModel):
    """To stand at the last waypoint: from the moment it is reached the robot's own standing has the motors."""

    time_s: Annotated[float, Quantity("s", gt=0, le=DAY_S)] = Field(10.0, description="how long")
    within_m: Tolerance = Field(0.5, description="how far from the waypoint the torso may be, all that time")
