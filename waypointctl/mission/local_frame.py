"""Latitudes and longitudes in a local frame: x east and y north of an origin, in [m].

An equirectangular projection on the WGS 84 ellipsoid: a degree is as long everywhere as it is at the origin. It is
exact along the two axes through the origin; elsewhere meridians come together, and that is its error.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, TypeAlias

Place: TypeAlias = tuple[float, float]  # latitude and longitude [deg]
Point: TypeAlias = tuple[float, float]  # x and y [m]

MAX_SPAN_M: Final = 10_000.0

_EQUATOR_M: Final = 6_378_137.0  # semi-major axis of WGS 84
_FLATTENING: Final = 1 / 298.257_223_563
_ECCENTRICITY_2: Final = _FLATTENING * (2 - _FLATTENING)


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """A frame around an origin (latitude, longitude) [deg]."""

    origin: Place

    def point(self, place: Place) -> Point:
        """Return where a place is in the frame."""
        latitude = math.radians(self.origin[0])
        curvature = 1 - _ECCENTRICITY_2 * math.sin(latitude) ** 2
        north_m = _EQUATOR_M * (1 - _ECCENTRICITY_2) / curvature**1.5  # radius of the meridian
        east_m = _EQUATOR_M / math.sqrt(curvature) * math.cos(latitude)  # radius of the parallel
        return (
            east_m * math.radians(_around(place[1] - self.origin[1])),
            north_m * math.radians(place[0] - self.origin[0]),
        )

    def error_m(self, places: Iterable[Place]) -> float:
        """Return by how much the frame puts places wrong at most [m], against the plane that touches the origin."""
        return max((math.dist(self.point(place), self._on_plane(place)) for place in places), default=0.0)

    def _on_plane(self, place: Place) -> Point:
        ax, ay, az = _in_space(self.origin)
        bx, by, bz = _in_space(place)
        dx, dy, dz = bx - ax, by - ay, bz - az
        latitude, longitude = (math.radians(angle) for angle in self.origin)
        out = dx * math.cos(longitude) + dy * math.sin(longitude)  # away from the Earth's axis
        east = dy * math.cos(longitude) - dx * math.sin(longitude)
        return east, dz * math.cos(latitude) - out * math.sin(latitude)


def span_m(points: Iterable[Point]) -> float:
    """Return the longer side of the box around points [m]."""
    xs, ys = zip(*points, strict=True)
    return float(max(max(xs) - min(xs), max(ys) - min(ys)))


def _around(degrees: float) -> float:
    """Return a difference of longitudes the short way around the Earth."""
    return (degrees + 180) % 360 - 180


def _in_space(place: Place) -> tuple[float, float, float]:
    latitude, longitude = (math.radians(angle) for angle in place)
    normal_m = _EQUATOR_M / math.sqrt(1 - _ECCENTRICITY_2 * math.sin(latitude) ** 2)
    across_m = normal_m * math.cos(latitude)
    return (
        across_m * math.cos(longitude),
        across_m * math.sin(longitude),
        normal_m * (1 - _ECCENTRICITY_2) * math.sin(latitude),
    )
