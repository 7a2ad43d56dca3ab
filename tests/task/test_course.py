from __future__ import annotations

import numpy as np
import pytest

from waypointctl.task.course import Course


def test_the_papers_course_is_four_waypoints_in_25_square_metres_around_10_10() -> None:
    rng = np.random.default_rng(0)
    drawn = np.stack([Course().draw(rng, np.zeros(2)) for _ in range(2000)])
    assert drawn.shape == (2000, 4, 2)
    assert drawn.min() >= 7.5
    assert drawn.max() <= 12.5
    # Evenly: means and spreads of a uniform law, each within 5 standard errors.
    np.testing.assert_allclose(drawn.mean(axis=(0, 1)), 10.0, atol=5 * 5 / np.sqrt(12 * 8000))
    np.testing.assert_allclose(drawn.std(axis=(0, 1)), 5 / np.sqrt(12), rtol=0.03)


def test_another_square_lies_where_it_is_put() -> None:
    course = Course(count=50, centre_m=(-3.0, 40.0), side_m=2.0)
    drawn = course.draw(np.random.default_rng(1), np.array([100.0, 100.0]))
    assert drawn.shape == (50, 2)
    assert (np.abs(drawn - [-3.0, 40.0]) <= 1.0).all()


def test_legs_are_as_long_as_asked_and_begin_at_the_robot() -> None:
    rng, start = np.random.default_rng(2), np.array([5.0, -7.0])
    course = Course(perimeter="legs", count=6, leg_m=(2.0, 3.0))
    drawn = np.stack([course.draw(rng, start) for _ in range(500)])
    places = np.concatenate([np.broadcast_to(start, (500, 1, 2)), drawn], axis=1)
    legs = np.diff(places, axis=1)
    lengths = np.hypot(legs[..., 0], legs[..., 1])
    assert lengths.min() >= 2.0 - 1e-12
    assert lengths.max() <= 3.0 + 1e-12
    assert lengths.mean() == pytest.approx(2.5, abs=0.03)
    bearings = np.arctan2(legs[..., 1], legs[..., 0])
    counts, _ = np.histogram(bearings, bins=8, range=(-np.pi, np.pi))
    assert counts.min() > 0.8 * 3000 / 8, "every direction is drawn alike"


def test_the_same_stream_draws_the_same_course() -> None:
    for course in (Course(), Course(perimeter="legs")):
        first, again = (course.draw(np.random.default_rng(7), np.zeros(2)) for _ in range(2))
        np.testing.assert_array_equal(first, again)
