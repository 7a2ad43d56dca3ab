"""A curated list of courses, of which each episode walks one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Cases:
    """The courses to draw from.

    Attributes:
        courses: each a course in the world frame: waypoints (x, y) [m]. They need not be of one length.
        weights: how often each is drawn, relative to the others; all alike unless given.
    """

    courses: tuple[tuple[tuple[float, float], ...], ...]
    weights: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a list that nothing can be drawn from."""
        if not self.courses or not all(self.courses):
            raise InputError("course.cases: there has to be a course, and every course needs a waypoint")
        if self.weights and len(self.weights) != len(self.courses):
            raise InputError(f"course.cases: {len(self.weights)} weights are not one for each of {len(self.courses)}")
        if not all(math.isfinite(weight) and weight > 0 for weight in self.weights):
            raise InputError(f"course.cases: weights {list(self.weights)} are not all > 0")

    @property
    def count(self) -> int:
        """Waypoints of the longest course."""
        return max(len(course) for course in self.courses)

    def draw(self, rng: np.random.Generator, start: FloatArray) -> FloatArray:
        """Return the waypoints (m, 2) of one course in the world frame [m], wherever the robot starts."""
        limits = list(accumulate(self.weights or [1.0] * len(self.courses)))
        number = int(np.searchsorted(limits, rng.random() * limits[-1], side="right"))
        # The product can round up to the last limit.
        return np.array(self.courses[min(number, len(self.courses) - 1)], np.float64)
