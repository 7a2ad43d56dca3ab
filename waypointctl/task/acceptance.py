"""When a waypoint counts as reached."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError

FloatArray = NDArray[np.float64]

SHAPES: Final = ("box", "radius")


@dataclass(frozen=True, slots=True)
class Acceptance:
    """The region around a waypoint that counts as having reached it.

    Attributes:
        shape: "box" (the paper's: |x - gx| < size and |y - gy| < size) or "radius" (distance < size).
        size_m: half the box's side, or the radius [m].
    """

    shape: str = "box"
    size_m: float = 0.5

    def __post_init__(self) -> None:
        """Refuse a shape that does not exist and a size that is not a positive length."""
        if self.shape not in SHAPES:
            raise InputError(f"acceptance.shape: {self.shape!r} is not one of {', '.join(SHAPES)}")
        if not (math.isfinite(self.size_m) and self.size_m > 0):
            raise InputError(f"acceptance.size_m: {self.size_m} is not > 0 m")


def reached(acceptance: Acceptance, position: FloatArray, goal: FloatArray) -> NDArray[np.bool_]:
    """Return which of the positions (n, >= 2) are within acceptance of their goal (n, 2)."""
    dx, dy = position[:, 0] - goal[:, 0], position[:, 1] - goal[:, 1]
    if acceptance.shape == "box":
        return (np.abs(dx) < acceptance.size_m) & (np.abs(dy) < acceptance.size_m)
    return dx * dx + dy * dy < acceptance.size_m**2
