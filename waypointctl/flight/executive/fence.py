"""The geofence: areas that the robot is to stay in, and areas that it is to stay out of.

A border belongs to its area. With several areas to stay in, being in one of them is enough, or all of them are required
as `keep_in_match` sets; every area to stay out of counts for itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Circle:
    """A round area: centre (x, y) and radius [m]."""

    name: str
    center_m: Point
    radius_m: float

    def holds(self, point: Point) -> bool:
        """Return whether a point [m] is in it."""
        return math.dist(point, self.center_m) <= self.radius_m

    def crossings(self, start: Point, end: Point) -> Iterator[float]:
        """Yield where the way from `start` to `end` meets the border, as fractions of the way."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        fx, fy = start[0] - self.center_m[0], start[1] - self.center_m[1]
        a, half_b = dx * dx + dy * dy, fx * dx + fy * dy
        root = half_b * half_b - a * (fx * fx + fy * fy - self.radius_m * self.radius_m)
        if a > 0 and root >= 0:
            yield (-half_b - math.sqrt(root)) / a
            yield (-half_b + math.sqrt(root)) / a


@dataclass(frozen=True, slots=True)
class Polygon:
    """An area with straight borders: its corners (x, y) [m] in either direction, the last joined to the first.

    Where it crosses itself, what an odd number of borders encloses is in it.
    """

    name: str
    corners_m: tuple[Point, ...]

    def holds(self, point: Point) -> bool:
        """Return whether a point [m] is in it."""
        x, y = point
        inside = False
        for (ax, ay), (bx, by) in self._edges():
            side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)  # > 0: left of the edge
            if side == 0 and min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by):
                return True
            # An edge counts where it passes the point's height: upward if the point is left of it, or downward
            # if right. Its lower end belongs to it and its upper end does not, so a corner counts once.
            if (ay <= y < by and side > 0) or (by <= y < ay and side < 0):
                inside = not inside
        return inside

    def crossings(self, start: Point, end: Point) -> Iterator[float]:
        """Yield where the way from `start` to `end` meets the border, as fractions of the way."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        for (ax, ay), (bx, by) in self._edges():
            ex, ey = bx - ax, by - ay
            across = dx * ey - dy * ex
            if across != 0:
                along_edge = ((ax - start[0]) * dy - (ay - start[1]) * dx) / across
                if 0 <= along_edge <= 1:
                    yield ((ax - start[0]) * ey - (ay - start[1]) * ex) / across

    def _edges(self) -> Iterator[tuple[Point, Point]]:
        return pairwise((*self.corners_m, self.corners_m[0]))


Area: TypeAlias = Circle | Polygon


@dataclass(frozen=True, slots=True)
class Fence:
    """What the robot is to stay in and out of. A fence without areas has room for everything."""

    keep_in: tuple[Area, ...] = ()
    keep_out: tuple[Area, ...] = ()
    keep_in_all: bool = False  # whether the robot has to be in every area of keep_in; else one is enough

    def breach(self, x_m: float, y_m: float) -> str:
        """Return how a place breaks the fence, as "is outside keep-in"; empty if it does not."""
        point = (x_m, y_m)
        outside = [area for area in self.keep_in if not area.holds(point)]
        if self.keep_in_all and outside:
            return f"is outside keep-in {outside[0].name}"
        if outside and len(outside) == len(self.keep_in):
            return "is outside keep-in"
        return next((f"is inside keep-out {area.name}" for area in self.keep_out if area.holds(point)), "")

    def breach_between(self, start: Point, end: Point) -> str:
        """Return how the straight way between two places [m] breaks the fence; empty if it does not."""
        place = self.first_breach(start, end)
        return "" if place is None else self.breach(*place)

    def first_breach(self, start: Point, end: Point) -> Point | None:
        """Return a place [m] in the first part of the straight way that breaks the fence; None if none does."""
        areas = (*self.keep_in, *self.keep_out)
        meets = sorted(at for area in areas for at in area.crossings(start, end) if 0 < at < 1)
        cuts = [0.0, *meets, 1.0]
        parts = [0.0, *((a + b) / 2 for a, b in pairwise(cuts)), 1.0]
        places = (_between(start, end, at) for at in parts)
        return next((place for place in places if self.breach(*place)), None)


def crosses(breach: str) -> str:
    """Return what a path that breaks the fence does, from the text of `breach`: "crosses keep-out 1"."""
    return breach.replace("is inside", "crosses").replace("is outside", "leaves")


def _between(start: Point, end: Point, at: float) -> Point:
    return start[0] + at * (end[0] - start[0]), start[1] + at * (end[1] - start[1])
