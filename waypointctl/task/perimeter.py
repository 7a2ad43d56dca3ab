"""The regions that waypoints are drawn in, each around its own centre, evenly over the area."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Square:
    """A square: the paper's perimeter.

    Attributes:
        side_m: its side.
        gap_rule: what `largest_gap_m` is, in words.
    """

    gap_rule: ClassVar[str] = "half its side"

    side_m: float

    @property
    def largest_gap_m(self) -> float:
        """The distance [m] beyond which, seen from any point of the plane, a fifth of the area still lies."""
        return self.side_m / 2

    def draw(self, rng: np.random.Generator, count: int) -> FloatArray:
        """Return points (count, 2) around the centre [m]."""
        half = self.side_m / 2
        return rng.uniform(-half, half, (count, 2))


@dataclass(frozen=True, slots=True)
class Ring:
    """What lies between two circles; with an inner radius of 0, a disc.

    Attributes:
        inner_radius_m: of the hole.
        radius_m: of the whole.
        gap_rule: what `largest_gap_m` is, in words.
    """

    gap_rule: ClassVar[str] = "0.85 of its radius"

    inner_radius_m: float
    radius_m: float

    @property
    def largest_gap_m(self) -> float:
        """The distance [m] beyond which, seen from any point of the plane, a fifth of the area still lies."""
        return 0.85 * self.radius_m

    def draw(self, rng: np.random.Generator, count: int) -> FloatArray:
        """Return points (count, 2) around the centre [m]."""
        # Evenly over the area: it grows with the square of the radius.
        radius = np.sqrt(rng.uniform(self.inner_radius_m**2, self.radius_m**2, count))
        bearing = rng.uniform(-math.pi, math.pi, count)
        return np.stack([radius * np.cos(bearing), radius * np.sin(bearing)], axis=1)
