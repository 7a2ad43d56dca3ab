"""What a mission loads into the robot: what it does by itself, without asking the ground."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, Strict, model_validator

from waypointctl.mission.fields import DAY_S, Name, Position, Timeout, Tolerance
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.polygon import crossing_sides
from waypointctl.mission.quantity import Quantity


class OnFailure(FileModel):
    """What to do when a leg fails. A bare word is what follows, without trying again."""

    text_stands_for: ClassVar[str | None] = "then"

    retry: Annotated[int, Strict(), Field(ge=0, le=1000)] = Field(0, description="how often the leg is begun again")
    then: Literal["abort", "skip", "hold", "return_home"] = Field(
        "abort", description="abort: give the plan up; skip: on to the next; hold: stand and wait for a command"
    )


class Stuck(FileModel):
    """When a robot counts as getting no closer to its waypoint."""

    within_m: Annotated[float, Quantity("m", gt=0, le=100)] = Field(0.1, description="less than this is no progress")
    for_s: Annotated[float, Quantity("s", gt=0, le=DAY_S)] = Field(5.0, description="so long without progress")


class LinkLoss(FileModel):
    """What to do when nothing arrives from the ground any more."""

    after_s: Annotated[float, Quantity("s", gt=0, le=10 * DAY_S)] = Field(
        description="since the last command or heartbeat; before the first there is no link to lose"
    )
    do: Literal["finish", "hold", "return_home"] = Field(
        "finish", description="finish: what has been released; hold: stand until something arrives"
    )


class Corner(FileModel):
    """A corner of a polygon. A bare [x, y] is the position."""

    list_stands_for: ClassVar[str | None] = "position_m"

    position_m: Position = Field(description="x and y in the world frame")


class Area(FileModel):
    """A circle, with `center` and `radius`, or a polygon, with `corners`; its border belongs to it."""

    name: Name | None = Field(None, description="1, 2, ... where it is left out")
    center_m: Position | None = Field(None, description="of a circle")
    radius_m: Annotated[float, Quantity("m", gt=0, le=20_000)] | None = Field(None, description="of a circle")
    corners: Annotated[tuple[Corner, ...], Field(min_length=3, max_length=1000)] | None = Field(
        None, description="of a polygon, in either direction"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        round_parts = (self.center_m is not None) + (self.radius_m is not None)
        if round_parts + (self.corners is not None) * 2 != 2:
            raise ValueError("is neither a circle (center and radius) nor a polygon (corners): give one of them")
        if self.corners is not None and not _spread_out(tuple(corner.position_m for corner in self.corners)):
            raise ValueError("has all its corners on one line: a polygon needs room inside")
        if self.corners is not None and (sides := crossing_sides([corner.position_m for corner in self.corners])):
            one, other = (_side(at, len(self.corners)) for at in sides)
            raise ValueError(f"crosses itself: its side {one} meets that {other}; give the corners in turn, round it")
        return self


class Geofence(FileModel):
    """Where the robot may be. A commanded waypoint elsewhere is rejected; `do` says what follows a breach."""

    keep_in: Annotated[tuple[Area, ...], Field(max_length=100)] = Field(
        (), description="to be in one of them, or in all of them, as keep_in_match says"
    )
    keep_in_match: Literal["any", "all"] = Field(
        "any", description="any: inside at least one area of keep_in; all: inside every area of keep_in"
    )
    keep_out: Annotated[tuple[Area, ...], Field(max_length=100)] = Field((), description="to be in none of them")
    do: Literal["hold", "return_home", "abort"] = Field("hold", description="when the robot walks out of the fence")


class Home(FileModel):
    """Where return_home goes."""

    position_m: Position | None = Field(None, description="x and y in the world frame; where the mission starts")
    tolerance_m: Tolerance = Field(0.5, description="how near is home")
    timeout_s: Timeout = Field(300.0, description="for the way home")


class Onboard(FileModel):
    """What the robot does by itself."""

    on_failure: OnFailure | None = Field(None, description="when a leg fails; may stand at the mission's top too")
    slip_m: Annotated[float, Quantity("m", ge=0, le=100)] = Field(
        0.0, description="a waypoint this near counts as reached once the robot gets no closer; 0: never"
    )
    stuck: Stuck | None = Field(None, description="a leg fails once the robot gets no closer; left out: by its time")
    link_loss: LinkLoss | None = Field(None, description="left out: the robot never minds")
    geofence: Geofence = Geofence()
    home: Home = Home()

    @property
    def progress(self) -> Stuck:
        """When the robot counts as getting no closer, for the slip also where it is never called stuck."""
        return self.stuck or Stuck()


def _side(at: int, count: int) -> str:
    return f"from corner {at + 1} to corner {(at + 1) % count + 1}"


def _spread_out(corners_m: tuple[Position, ...]) -> bool:
    """Tell whether some three of the corners are not on one line."""
    (ax, ay), *others = corners_m
    bx, by = max(others, key=lambda corner: abs(corner[0] - ax) + abs(corner[1] - ay))
    return any((bx - ax) * (y - ay) != (by - ay) * (x - ax) for x, y in others)
