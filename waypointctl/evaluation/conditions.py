"""What of a suite says when a trial counts as a success."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import Field, ValidationError

from waypointctl.errors import InputError
from waypointctl.mission.fields import DAY_S, Acceptance, Tolerance
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.units import NUMBER_PATTERN


def parse_acceptance(text: str) -> Acceptance:
    """Read an acceptance region as a command line has it: "radius:0.2", "box:0.5" or "box:50cm"; a bare number is in m.

    Raises:
        InputError: it is none.
    """
    shape, _, size = text.partition(":")
    spelling = "size_m" if re.fullmatch(NUMBER_PATTERN, size.strip()) else "size"
    try:
        value = float(size) if spelling == "size_m" else size
        return Acceptance.model_validate({"shape": shape.strip(), spelling: value})
    except ValidationError as error:
        problem = f"{text!r} is not an acceptance region: a shape, box or radius, and a size up to 100 m"
        raise InputError(problem, where="--acceptance", hint="such as radius:0.2 or box:50cm") from error


class Hold(FileModel):
    """To stand at the last waypoint: from the moment it is reached the robot's own standing has the motors."""

    time_s: Annotated[float, Quantity("s", gt=0, le=DAY_S)] = Field(10.0, description="how long")
    within_m: Tolerance = Field(0.5, description="how far from the waypoint the torso may be, all that time")
