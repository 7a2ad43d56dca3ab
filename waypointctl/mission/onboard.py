"""The rules that the robot applies on board: failed legs, no progress, loss of the link, home, and the geofence."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, Literal, Self, TypeAlias

from pydantic import Field, Strict, model_validator

from waypointctl.mission.fields import DAY_S, Name, Position, Timeout, Tolerance
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity

Point: TypeAlias = tuple[float, float]

CIRCLE_CORNERS: Final = 72  # of a circle as it is drawn


class Corner(FileModel):
    """A corner of a polygon. A bare [x, y] is the position."""

    list_shorthand: ClassVar[str | None] = "position_m"

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
    """Where the robot may be. A commanded waypoint elsewhere is rejected; `do` sets what follows a breach."""

    keep_in: Annotated[tuple[Area, ...], Field(max_length=100)] = Field(
        (), description="areas to stay in: one of them, or all of them, as keep_in_match sets"
    )
    keep_in_match: Literal["any", "all"] = Field(
        "any", description="any: inside at least one area of keep_in; all: inside every area of keep_in"
    )
    keep_out: Annotated[tuple[Area, ...], Field(max_length=100)] = Field((), description="areas to stay out of")
    do: Literal["hold", "return_home", "abort"] = Field("hold", description="when the robot leaves the fence")


@dataclass(frozen=True, slots=True)
class Zone:
    """A zone that the robot has to stay in, or out of."""

    name: str  # as messages have it: its own, or its place among those of its kind
    keep_in: bool  # whether the robot has to stay in it; if not, out of it
    outline_m: tuple[Point, ...]  # its corners (x, y) [m], the last joined to the first

    @property
    def label(self) -> str:
        """What it is and what it is called."""
        return f"{'keep-in' if self.keep_in else 'keep-out'} {self.name}"


def zones_of(geofence: Geofence) -> tuple[Zone, ...]:
    """Return the zones of a geofence, those to stay in first."""
    return (*_zones(geofence.keep_in, keep_in=True), *_zones(geofence.keep_out, keep_in=False))


def _zones(areas: tuple[Area, ...], *, keep_in: bool) -> Iterator[Zone]:
    for place, area in enumerate(areas, 1):
        yield Zone(area.name or str(place), keep_in, tuple(_outline(area)))


def _outline(area: Area) -> Iterator[Point]:
    if area.corners is not None:
        yield from (corner.position_m for corner in area.corners)
        return
    assert area.center_m is not None
    assert area.radius_m is not None
    for corner in range(CIRCLE_CORNERS):
        turn = 2 * math.pi * corner / CIRCLE_CORNERS
        yield area.center_m[0] + area.radius_m * math.cos(turn), area.center_m[1] + area.radius_m * math.sin(turn)


def _side(at: int, count: int) -> str:
    return f"from corner {at + 1} to corner {(at + 1) % count + 1}"


def _spread_out(corners_m: tuple[Position, ...]) -> bool:
    """Tell whether some three of the corners are not on one line."""
    (ax, ay), *others = corners_m
    bx, by = max(others, key=lambda corner: abs(corner[0] - ax) + abs(corner[1] - ay))
    return any((bx - ax) * (y - ay) != (by - ay) * (x - ax) for x, y in others)


def crossing_sides(corners: Sequence[Point]) -> tuple[int, int] | None:
    """Return two sides of a polygon that cross, each by the index of its first corner; None where none do.

    Sides that only touch do not cross: corners given twice, and a hole cut in by a slit, are allowed.

    Args:
        corners: (x, y) in either direction, the last joined to the first.
    """
    sides = [(a, b, at) for at, (a, b) in enumerate(zip(corners, (*corners[1:], corners[0]), strict=True))]
    sides.sort(key=lambda side: min(side[0][0], side[1][0]))
    for place, (a, b, at) in enumerate(sides):
        right, top, bottom = max(a[0], b[0]), max(a[1], b[1]), min(a[1], b[1])
        for c, d, other in sides[place + 1 :]:
            if min(c[0], d[0]) > right:  # this one and all after it lie to the right
                break
            if min(c[1], d[1]) > top or max(c[1], d[1]) < bottom:
                continue
            if _cross(a, b, c, d):
                return min(at, other), max(at, other)
    return None


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Tell whether a to b and c to d have a point in common that ends neither."""
    return _left(a, b, c) * _left(a, b, d) < 0 and _left(c, d, a) * _left(c, d, b) < 0


def _left(a: Point, b: Point, point: Point) -> float:
    """Return a number > 0 where a point lies left of the way from a to b, and < 0 where it lies right."""
    turn = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
    return (turn > 0) - (turn < 0)  # its sign alone: products of tiny numbers would vanish


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

    position_m: Position | None = Field(None, description="in the world frame; without it, where the mission starts")
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
