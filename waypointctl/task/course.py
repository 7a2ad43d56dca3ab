"""Where the waypoints of an episode come from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError

FloatArray = NDArray[np.float64]

PERIMETERS: Final = ("square", "legs")


@dataclass(frozen=True, slots=True)
class Course:
    """How the waypoints of an episode are drawn.

    Attributes:
        perimeter: "square" draws each waypoint in a square (the paper's: 25 m^2 around (10, 10)); "legs" draws each
            leg's length and direction, starting at the robot, so that a course may lead anywhere.
        count: waypoints an episode, the paper's M.
        centre_m: the square's centre.
        side_m: the square's side.
        leg_m: the shortest and the longest leg.
    """

    perimeter: str = "square"
    count: int = 4
    centre_m: tuple[float, float] = (10.0, 10.0)
    side_m: float = 5.0
    leg_m: tuple[float, float] = (1.0, 12.0)

    def __post_init__(self) -> None:
        """Refuse a course that cannot be drawn."""
        if self.perimeter not in PERIMETERS:
            raise InputError(f"course.perimeter: {self.perimeter!r} is not one of {', '.join(PERIMETERS)}")
        if self.count < 1:
            raise InputError(f"course.count: {self.count} is not >= 1 waypoint")
        if not self.side_m > 0:
            raise InputError(f"course.side_m: {self.side_m} is not > 0 m")
        if not 0 <= self.leg_m[0] <= self.leg_m[1]:
            raise InputError(f"course.leg_m: {list(self.leg_m)} is not a shortest and a longest length in m")

    def draw(self, rng: np.random.Generator, start: FloatArray) -> FloatArray:
        """Return waypoints (count, 2) in the world frame [m] for a robot at start (2,)."""
        if self.perimeter == "square":
            half = self.side_m / 2
            return np.asarray(self.centre_m) + rng.uniform(-half, half, (self.count, 2))
        length = rng.uniform(*self.leg_m, self.count)
        bearing = rng.uniform(-math.pi, math.pi, self.count)
        legs = np.stack([length * np.cos(bearing), length * np.sin(bearing)], axis=1)
        return start + np.cumsum(legs, axis=0)


@dataclass(frozen=True, slots=True)
class Deadline:
    """How long an episode may take: the paper's Algorithm 1.

    Attributes:
        first_s: to reach the first waypoint [s].
        further_s: added for each waypoint reached [s].
    """

    first_s: float = 10.0
    further_s: float = 20.0
