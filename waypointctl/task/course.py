"""Where the waypoints of an episode come from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.task.perimeter import Ring, Square

FloatArray = NDArray[np.float64]

# The perimeters, each with the fields of a Course that it is drawn by.
PERIMETERS: Final = {
    "square": ("count", "centre_m", "side_m", "min_distance_m"),
    "disc": ("count", "centre_m", "radius_m", "min_distance_m"),
    "ring": ("count", "centre_m", "inner_radius_m", "radius_m", "min_distance_m"),
    "legs": ("count", "leg_m"),
    "none": ("count", "leg_m"),
}

# Each try has a fifth of a chance at least (largest_gap_m), so that no draw ever comes to the last one.
_TRIES: Final = 1000


@dataclass(frozen=True, slots=True)
class Course:
    """How the waypoints of an episode are drawn.

    Attributes:
        perimeter: "square" draws each waypoint in a square (the paper's: 25 m^2 around (10, 10)), "disc" in a circle,
            "ring" between two circles, evenly over the area; "legs" draws each leg's length and direction, starting at
            the robot, so that a course may lead anywhere. "none" is "legs" by its other name: no perimeter.
        count: waypoints an episode, the paper's M.
        centre_m: the square's, the disc's or the ring's centre.
        side_m: the square's side.
        leg_m: the shortest and the longest leg.
        radius_m: the disc's radius, and the ring's outer one.
        inner_radius_m: the ring's inner radius.
        min_distance_m: no waypoint is nearer than this to the one before it, nor the first to the start; 0 for any.
    """

    perimeter: str = "square"
    count: int = 4
    centre_m: tuple[float, float] = (10.0, 10.0)
    side_m: float = 5.0
    leg_m: tuple[float, float] = (1.0, 12.0)
    radius_m: float = 2.5
    inner_radius_m: float = 0.0
    min_distance_m: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a course that cannot be drawn."""
        if self.perimeter not in PERIMETERS:
            raise InputError(f"course.perimeter: {self.perimeter!r} is not one of {', '.join(PERIMETERS)}")
        if self.count < 1:
            raise InputError(f"course.count: {self.count} is not >= 1 waypoint")
        for name in ("side_m", "radius_m"):
            if not (math.isfinite(length := getattr(self, name)) and length > 0):
                raise InputError(f"course.{name}: {length} is not > 0 m")
        if not 0 <= self.leg_m[0] <= self.leg_m[1]:
            raise InputError(f"course.leg_m: {list(self.leg_m)} is not a shortest and a longest length in m")
        if self.perimeter == "ring" and not 0 <= self.inner_radius_m < self.radius_m:
            raise InputError(f"course.inner_radius_m: {self.inner_radius_m} is not less than radius_m {self.radius_m}")
        if self.min_distance_m and not 0 < self.min_distance_m <= self.largest_min_distance_m:
            raise InputError(f"course.min_distance_m: {self.min_distance_m} {self.min_distance_rule}")

    @property
    def region(self) -> Square | Ring | None:
        """Where waypoints are drawn, around the centre; None where they may be anywhere."""
        match self.perimeter:
            case "square":
                return Square(self.side_m)
            case "disc":
                return Ring(0.0, self.radius_m)
            case "ring":
                return Ring(self.inner_radius_m, self.radius_m)
        return None

    @property
    def largest_min_distance_m(self) -> float:
        """The largest `min_distance_m` that can be drawn wherever the waypoint before lies [m]; 0 without perimeter."""
        region = self.region
        return 0.0 if region is None else region.largest_gap_m

    @property
    def min_distance_rule(self) -> str:
        """What is wrong with a `min_distance_m` outside of what is allowed, in words that follow it."""
        region = self.region
        if region is None:
            return "needs a perimeter; without one the shortest leg is the least distance"
        most = f"{region.largest_gap_m:g} m ({region.gap_rule})"
        return f"is not from 0 to {most}, the most that this {self.perimeter} has room for"

    def draw(self, rng: np.random.Generator, start: FloatArray) -> FloatArray:
        """Return waypoints (count, 2) in the world frame [m] for a robot at start (2,)."""
        region = self.region
        if region is None:
            return self._legs(rng, start)
        if not self.min_distance_m:
            return np.asarray(self.centre_m) + region.draw(rng, self.count)
        return self._apart(rng, start, region)

    def _legs(self, rng: np.random.Generator, start: FloatArray) -> FloatArray:
        length = rng.uniform(*self.leg_m, self.count)
        bearing = rng.uniform(-math.pi, math.pi, self.count)
        legs = np.stack([length * np.cos(bearing), length * np.sin(bearing)], axis=1)
        return start + np.cumsum(legs, axis=0)

    def _apart(self, rng: np.random.Generator, start: FloatArray, region: Square | Ring) -> FloatArray:
        """Draw each waypoint again until it is far enough from the one before."""
        waypoints, before = np.empty((self.count, 2)), start
        for waypoint in waypoints:
            for _ in range(_TRIES):
                waypoint[:] = np.asarray(self.centre_m) + region.draw(rng, 1)[0]
                if math.dist(waypoint, before) >= self.min_distance_m:
                    break
            else:
                raise InputError(f"course.min_distance_m: no waypoint {self.min_distance_m} m from {before} was found")
            before = waypoint
        return waypoints


@dataclass(frozen=True, slots=True)
class Deadline:
    """How long an episode may take: the paper's Algorithm 1.

    Attributes:
        first_s: to reach the first waypoint [s].
        further_s: added for each waypoint reached [s].
    """

    first_s: float = 10.0
    further_s: float = 20.0
