"""What a mission says of the operator, who is a script, and of how hard commands are sent."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Field, Strict

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity

_DAY_S: Final = 86_400.0


class OperatorScript(FileModel):
    """How the scripted operator behaves."""

    think_s: Annotated[float, Quantity("s", ge=0, le=_DAY_S)] = Field(
        0.0, description="from hearing what decides to sending what follows from it"
    )
    released: Annotated[int, Strict(), Field(ge=-1)] = Field(
        -1, description="autonomy mission: how many waypoints may be walked to until more are released; -1 for all"
    )
    steering: Literal["move_and_wait", "continuous"] = Field(
        "move_and_wait",
        description="autonomy short_range_goal: the next goal when the last was heard to be over, or at a rate",
    )
    lookahead_m: Annotated[float, Quantity("m", ge=0.1, le=100)] = Field(
        1.0, description="autonomy short_range_goal: how far ahead of the robot its short-range goal lies"
    )
    update_rate_hz: Annotated[float, Quantity("hz", ge=0.001, le=50)] = Field(
        1.0, description="autonomy short_range_goal, continuous: goals a second"
    )
    heartbeat_s: Annotated[float, Quantity("s", ge=0.02, le=_DAY_S)] | None = Field(
        None, description="a sign of life is sent this often, for the robot to tell when the link is lost"
    )


class Commanding(FileModel):
    """How hard the ground tries to be heard."""

    acknowledged: Annotated[bool, Strict()] = Field(
        True, description="whether a command is sent again when its acknowledgement is late"
    )
    retries: Annotated[int, Strict(), Field(ge=0, le=1000)] = Field(
        3, description="how often a command is sent again at most, whatever for"
    )
    margin_s: Annotated[float, Quantity("s", ge=0, le=_DAY_S)] = Field(
        1.0, description="what an acknowledgement may be late beyond round trip, jitter, rate and contacts"
    )
