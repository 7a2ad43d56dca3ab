from __future__ import annotations

import numpy as np
import pytest

from tests.task.uniformity import assert_even
from waypointctl.task.course import Ring, Square


def test_a_square_is_filled_evenly() -> None:
    drawn = Square(8.0).draw(np.random.default_rng(0), 4000)
    assert drawn.shape == (4000, 2)
    for along in drawn.T:
        assert_even(along, -4, 4)


@pytest.mark.parametrize(("inner", "outer"), [(0.0, 3.0), (2.0, 3.0), (2.9, 3.0)])
def test_a_ring_is_filled_evenly(inner: float, outer: float) -> None:
    x, y = Ring(inner, outer).draw(np.random.default_rng(1), 4000).T
    # Of a region's area, what lies within a radius grows with the square of it; directions are all alike.
    assert_even(x**2 + y**2, inner**2, outer**2)
    assert_even(np.arctan2(y, x), -np.pi, np.pi)
    assert_even((np.arctan2(y, x) + 1) % (np.pi / 2), 0, np.pi / 2)


def area(region: Square | Ring) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return the points of a fine lattice that lie in a region, (n, 2)."""
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-1, 1, 121)] * 2))
    if isinstance(region, Square):
        inside = np.maximum(np.abs(x), np.abs(y)) <= region.side_m / 2
    else:
        inside = (np.hypot(x, y) <= region.radius_m) & (np.hypot(x, y) >= region.inner_radius_m)
    return np.stack([x[inside], y[inside]], axis=1)


@pytest.mark.parametrize(
    "region", [Square(2.0), Ring(0.0, 1.0), Ring(0.2, 1.0), Ring(0.5, 1.0), Ring(0.8, 1.0), Ring(0.97, 1.0)]
)
def test_wherever_one_stands_a_fifth_of_the_area_is_farther_away_than_the_largest_gap(region: Square | Ring) -> None:
    points = area(region)
    bearings = np.linspace(0, np.pi / 4, 4)
    shares = [
        np.mean(np.hypot(*(points - distance * np.array([np.cos(bearing), np.sin(bearing)])).T) >= region.largest_gap_m)
        for distance in np.linspace(0, 1.6, 17)
        for bearing in bearings
    ]
    assert min(shares) > 0.2
