"""Latitudes and longitudes in a local frame: x east and y north of an origin, in [m], on the Earth or another body.

An azimuthal equidistant projection by geographiclib's geodesics: each place has its true distance and direction from
the origin. Distances between other places are too long by at most s^3 / (6 R^2), 4 mm within 10 km on the Earth.
A line of more places than a mission has waypoints is thinned in it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.units import DISTANCE_UNITS_M, quantity

if TYPE_CHECKING:
    from geographiclib.geodesic import Geodesic

Place: TypeAlias = tuple[float, float]  # latitude and longitude [deg]
Point: TypeAlias = tuple[float, float]  # x and y [m]

_MAX_SPAN_M: Final = 10_000.0  # as far as a mission's coordinates go
_MAX_SHARE: Final = 0.01  # of the radius: on a small body the ground curves away sooner
_LEAST_RADIUS_M: Final = 10_000.0
_MOST_RADIUS_M: Final = 1e8


@dataclass(frozen=True)
class Body:
    """The ground body: an ellipsoid with its equatorial radius [m] and its flattening."""

    name: str
    equator_m: float
    flattening: float = 0.0

    @cached_property
    def geodesic(self) -> Geodesic:
        """Solves geodesics on the body."""
        from geographiclib.geodesic import Geodesic

        return Geodesic(self.equator_m, self.flattening)


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
    _points: dict[Place, Point] = field(default_factory=dict, compare=False, repr=False)

    @property
    def max_span_m(self) -> float:
        """How far places may be apart."""
        return min(_MAX_SPAN_M, _MAX_SHARE * self.body.equator_m)

    def point(self, place: Place) -> Point:
        """Return where a place is in the frame; the first time takes about 0.1 ms."""
        if place not in self._points:
            way = self.body.geodesic.Inverse(*self.origin, *place)
            azimuth = math.radians(way["azi1"])  # from north to east
            self._points[place] = way["s12"] * math.sin(azimuth), way["s12"] * math.cos(azimuth)
        return self._points[place]


def span_m(points: Iterable[Point]) -> float:
    """Return the longer side of the box around points [m]."""
    xs, ys = zip(*points, strict=True)
    return float(max(max(xs) - min(xs), max(ys) - min(ys)))


def thinned(points: Sequence[Point], needed: Sequence[int], tolerance_m: float, most: int) -> list[int] | None:
    """Return which places of a line to keep, by Douglas and Peucker's rule; None if they are too many.

    Args:
        points: x and y [m] along the line.
        needed: indices of those to keep whatever their place; the first and the last of the line are kept anyway.
        tolerance_m: no place that is dropped is further than this from the straight way between those kept around it.
        most: places to keep.

    Returns:
        Indices in order.
    """
    line = np.array(points, dtype=np.float64)  # (n, 2) [m]
    kept = sorted({0, len(line) - 1, *needed})
    spans = list(pairwise(kept))
    while spans and len(kept) <= most:
        begin, end = spans.pop()
        if end - begin < 2:
            continue
        away_m = _away_m(line[begin + 1 : end], line[begin], line[end])
        farthest = int(np.argmax(away_m))
        if away_m[farthest] > tolerance_m:
            middle = begin + 1 + farthest
            kept.append(middle)
            spans += [(begin, middle), (middle, end)]
    return sorted(kept) if len(kept) <= most else None


def _away_m(points: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (n,) [m] of points (n, 2) from the straight way between two places."""
    way = b - a
    length_2 = float(way @ way)
    along = np.clip((points - a) @ way / length_2, 0.0, 1.0) if length_2 > 0 else np.zeros(len(points))
    away = points - a - along[:, None] * way
    return np.hypot(away[:, 0], away[:, 1])
