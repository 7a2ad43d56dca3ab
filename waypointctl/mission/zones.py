"""A geofence's zones as outlines, for everything that draws them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

from waypointctl.mission.onboard import Area, Geofence

Point: TypeAlias = tuple[float, float]

CIRCLE_CORNERS: Final = 72  # of a circle as it is drawn


@dataclass(frozen=True, slots=True)
class Zone:
    """A zone that the robot has to stay in, or out of.

    Attributes:
        name: as messages have it: its own, or its place among those of its kind.
        keep_in: whether the robot has to stay in it; if not, out of it.
        outline_m: its corners (x, y) [m], the last joined to the first.
    """

    name: str
    keep_in: bool
    outline_m: tuple[Point, ...]

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
