from __future__ import annotations

import math

import numpy as np
import pytest

from waypointctl.studies.flights import Estimate, mean, slope, student


@pytest.mark.parametrize(
    ("freedom", "tabled"), [(1, 12.706), (2, 4.303), (4, 2.776), (19, 2.093), (30, 2.042), (120, 1.980), (5000, 1.960)]
)
def test_students_t_is_the_tables(freedom: int, tabled: float) -> None:
    assert student(freedom) == pytest.approx(tabled, abs=5e-4)


def test_a_mean_has_the_interval_of_the_textbook() -> None:
    # The heights of ten, mean 173, deviation 6.0553: 2.2622 x 6.0553 / sqrt(10).
    heights = [165.0, 168, 170, 172, 173, 173, 174, 175, 176, 184]
    found = mean(heights)
    deviation = math.sqrt(sum((height - 173) ** 2 for height in heights) / 9)
    assert found.value == pytest.approx(173.0)
    assert found.half == pytest.approx(2.2622 * deviation / math.sqrt(10), rel=1e-4)


def test_one_value_says_nothing_of_its_spread() -> None:
    assert mean([3.5]) == Estimate(value=3.5, half=None)
    assert str(mean([3.5])) == "3.50"
    assert str(mean([3.0, 3.0])) == "3.00 ± 0.00"


def test_a_slope_is_that_of_least_squares() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(0, 40, 50)
    y = 7 + 10 * x + rng.normal(0, 3, 50)
    coefficients, covariance = np.polyfit(x, y, 1, cov=True)
    found = slope(x.tolist(), y.tolist())
    assert found.value == pytest.approx(coefficients[0])
    assert found.half == pytest.approx(student(48) * math.sqrt(covariance[0, 0]))


def test_the_intervals_of_a_slope_hold_it_95_times_in_100() -> None:
    rng = np.random.default_rng(2)
    x = [0.0, 0.4, 2.56, 5.0]
    found = [slope(x, (2 * np.array(x) + rng.normal(0, 1, 4)).tolist()) for _ in range(2000)]
    held = sum(abs(one.value - 2) <= (one.half or 0) for one in found)
    assert 0.935 < held / 2000 < 0.965


def test_two_points_make_a_slope_and_one_makes_none() -> None:
    assert slope([0.0, 2.0], [1.0, 5.0]) == Estimate(value=2.0, half=None)
    with pytest.raises(ValueError, match="two different x"):
        slope([1.0, 1.0, 1.0], [1.0, 2.0, 3.0])
