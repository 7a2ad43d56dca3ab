"""Latitudes and longitudes in a local frame: x east and y north of an origin, in [m], on the Earth or another body.

An equirectangular projection on the body's ellipsoid: a degree is as long everywhere as it is at the origin. It is
exact along the two axes through the origin; elsewhere meridians come together, and that is its error.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, TypeAlias

from waypointctl.errors import InputError
from waypointctl.units import DISTANCE_UNITS_M, quantity

Place: TypeAlias = tuple[float, float]  # latitude and longitude [deg]
Point: TypeAlias = tuple[float, float]  # x and y [m]

MAX_LATITUDE: Final = 89.0  # beyond, a degree of longitude is no length any more

_MAX_SPAN_M: Final = 10_000.0  # as far as a mission's coordinates go
_MAX_SHARE: Final = 0.01  # of the radius: on a small body the ground curves away sooner
_LEAST_RADIUS_M: Final = 10_000.0
_MOST_RADIUS_M: Final = 1e8


@dataclass(frozen=True, slots=True)
class Body:
    """What the robot stands on: an ellipsoid with its equator's radius [m] and its flattening."""

    name: str
    equator_m: float
    flattening: float = 0.0

    @property
    def eccentricity_2(self) -> float:
        """The square of the first eccentricity."""
        return self.flattening * (2 - self.flattening)


EARTH: Final = Body("the Earth", 6_378_137.0, 1 / 298.257_223_563)  # WGS 84
# The spheres of the IAU's working group (2015) that maps of the two are made on, with planetocentric latitudes.
BODIES: Final = {
    "earth": EARTH,
    "moon": Body("the Moon", 1_737_400.0),
    "mars": Body("Mars", 3_396_190.0),
}


def body_of(text: str) -> Body:
    """Return a body from its name, or from the radius of a sphere with its unit.

    Raises:
        InputError: it is neither.
    """
    if text.strip().lower() in BODIES:
        return BODIES[text.strip().lower()]
    hint = "Give --body earth, moon or mars, or the radius of a sphere, as in --body '1737.4 km'."
    try:
        radius_m = quantity(text, DISTANCE_UNITS_M)
    except ValueError:
        raise InputError(f"--body: {text!r} is not a body, and not a radius with its unit", hint=hint) from None
    if not _LEAST_RADIUS_M <= radius_m <= _MOST_RADIUS_M:
        limits = f"within {_LEAST_RADIUS_M / 1000:g} and {_MOST_RADIUS_M / 1000:g} km"
        raise InputError(f"--body: {text!r} is not a radius {limits}", hint=hint)
    return Body(f"a sphere of {radius_m / 1000:g} km", radius_m)


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """A frame around an origin (latitude, longitude) [deg]."""

    origin: Place
    body: Body = EARTH

    @property
    def max_span_m(self) -> float:
        """How far places may be apart."""
        return min(_MAX_SPAN_M, _MAX_SHARE * self.body.equator_m)

    def point(self, place: Place) -> Point:
        """Return where a place is in the frame."""
        latitude = math.radians(self.origin[0])
        curvature = 1 - self.body.eccentricity_2 * math.sin(latitude) ** 2
        north_m = self.body.equator_m * (1 - self.body.eccentricity_2) / curvature**1.5  # radius of the meridian
        east_m = self.body.equator_m / math.sqrt(curvature) * math.cos(latitude)  # radius of the parallel
        return (
            east_m * math.radians(_around(place[1] - self.origin[1])),
            north_m * math.radians(place[0] - self.origin[0]),
        )

    def error_m(self, places: Iterable[Place]) -> float:
        """Return by how much the frame puts places wrong at most [m], against the plane that touches the origin."""
        return max((math.dist(self.point(place), self._on_plane(place)) for place in places), default=0.0)

    def _on_plane(self, place: Place) -> Point:
        ax, ay, az = self._in_space(self.origin)
        bx, by, bz = self._in_space(place)
        dx, dy, dz = bx - ax, by - ay, bz - az
        latitude, longitude = (math.radians(angle) for angle in self.origin)
        out = dx * math.cos(longitude) + dy * math.sin(longitude)  # away from the body's axis
        east = dy * math.cos(longitude) - dx * math.sin(longitude)
        return east, dz * math.cos(latitude) - out * math.sin(latitude)

    def _in_space(self, place: Place) -> tuple[float, float, float]:
        latitude, longitude = (math.radians(angle) for angle in place)
        normal_m = self.body.equator_m / math.sqrt(1 - self.body.eccentricity_2 * math.sin(latitude) ** 2)
        across_m = normal_m * math.cos(latitude)
        return (
            across_m * math.cos(longitude),
            across_m * math.sin(longitude),
            normal_m * (1 - self.body.eccentricity_2) * math.sin(latitude),
        )


def span_m(points: Iterable[Point]) -> float:
    """Return the longer side of the box around points [m]."""
    xs, ys = zip(*points, strict=True)
    return float(max(max(xs) - min(xs), max(ys) - min(ys)))


def _around(degrees: float) -> float:
    """Return a difference of longitudes the short way around."""
    return (degrees + 180) % 360 - 180
