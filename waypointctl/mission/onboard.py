"""The rules that the robot applies on board: failed legs, no progress, loss of the link, geofence, home."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, Strict

from waypointctl.mission.fields import DAY_S, Position, Timeout, Tolerance
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.geofence import Geofence
from waypointctl.mission.quantity import Quantity


class OnFailure(FileModel):
    """What to do when a leg fails. A bare word is `then`, without a retry."""

    text_shorthand: ClassVar[str | None] = "then"

    retry: Annotated[int, Strict(), Field(ge=0, le=1000)] = Field(0, description="how often the leg is started again")
    then: Literal["abort", "skip", "hold", "return_home"] = Field(
        "abort", description="abort: end the plan; skip: continue with the next; hold: stop and wait for a command"
    )


class Stuck(FileModel):
    """When a robot counts as getting no closer to its waypoint."""

    within_m: Annotated[float, Quantity("m", gt=0, le=100)] = Field(
        0.1, description="a smaller decrease of the distance is not progress"
    )
    for_s: Annotated[float, Quantity("s", gt=0, le=DAY_S)] = Field(5.0, description="for this long")


class LinkLoss(FileModel):
    """What the robot does when nothing arrives from the operator."""

    after_s: Annotated[float, Quantity("s", gt=0, le=10 * DAY_S)] = Field(
        description="since the last command or heartbeat; the timer starts with the first"
    )
    do: Literal["finish", "hold", "return_home"] = Field(
        "finish", description="finish: complete the released waypoints; hold: stop until something arrives"
    )


class Home(FileModel):
    """Where return_home goes."""

    position_m: Position | None = Field(None, description="x and y in the world frame; where the mission starts")
    tolerance_m: Tolerance = Field(0.5, description="radius around home within which it counts as reached")
    timeout_s: Timeout = Field(300.0, description="for the return home")


class Onboard(FileModel):
    """What the robot does by itself."""

    former_keys: ClassVar[Mapping[str, str]] = {"slip": "stopped_tolerance", "slip_m": "stopped_tolerance_m"}

    on_failure: OnFailure | None = Field(None, description="when a leg fails; may also be a top-level key")
    stopped_tolerance_m: Annotated[float, Quantity("m", ge=0, le=100)] = Field(
        0.0, description="a waypoint this near counts as reached once the robot gets no closer; 0: never"
    )
    stuck: Stuck | None = Field(
        None, description="a leg fails once the robot gets no closer; left out: only by its timeout"
    )
    link_loss: LinkLoss | None = Field(None, description="left out: nothing")
    geofence: Geofence = Geofence()
    home: Home = Home()

    @property
    def progress(self) -> Stuck:
        """When the robot counts as getting no closer, also for `stopped_tolerance` where `stuck` is left out."""
        return self.stuck or Stuck()
