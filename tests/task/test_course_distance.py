from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError

from tests.task.uniformity import assert_even
from waypointctl.task.course import Course

FloatArray = NDArray[np.float64]

START = np.array([1.0, -2.0])
PERIMETERS = [
    Course(perimeter="square", count=6, centre_m=(1.0, -2.0), side_m=6.0),
    Course(perimeter="disc", count=6, centre_m=(1.0, -2.0), radius_m=3.0),
    Course(perimeter="ring", count=6, centre_m=(1.0, -2.0), radius_m=3.0, inner_radius_m=1.0),
]


def gaps(course: Course, draws: int) -> FloatArray:
    """Return the distances between each waypoint and the one before, (draws, count); the first is from the start."""
    rng = np.random.default_rng(3)
    places = np.stack([np.vstack([START, course.draw(rng, START)]) for _ in range(draws)])
    legs: FloatArray = np.diff(places, axis=1)
    return np.hypot(legs[..., 0], legs[..., 1])


def apart(course: Course, distance_m: float) -> Course:
    return course.model_copy(update={"min_distance_m": distance_m})


@pytest.mark.parametrize("course", PERIMETERS, ids=lambda course: course.perimeter)
def test_no_waypoint_is_nearer_to_the_one_before_than_allowed(course: Course) -> None:
    assert np.mean(gaps(course, 300) < 2.0) > 0.2, "without the option many are"
    for distance_m in (2.0, course.region.largest_gap_m if course.region else 0.0):
        drawn = gaps(apart(course, distance_m), 300)
        assert drawn.min() >= distance_m
        assert drawn[:, 1:].max() > 1.2 * distance_m, "and not all are at the very distance"


def test_what_is_far_enough_is_drawn_evenly() -> None:
    course = Course(perimeter="disc", count=1, centre_m=(1.0, -2.0), radius_m=3.0, min_distance_m=2.0)
    assert_even(gaps(course, 2000) ** 2, 4, 9)


def test_a_waypoint_follows_as_it_would_among_all_that_are_far_enough() -> None:
    plain = Course(perimeter="square", count=2, side_m=4.0, min_distance_m=0.0)
    rng, far = np.random.default_rng(4), np.array([-50.0, 0.0])
    pairs = np.stack([plain.draw(rng, far) for _ in range(6000)])
    # The oracle: waypoints in the quarter at the corner, and of all draws those that are far enough.
    first, second = pairs[:, 0] - 10.0, pairs[:, 1] - 10.0
    allowed = (first > 0).all(axis=1) & (np.hypot(*(second - first).T) >= 2.0)
    expected = second[allowed].mean(axis=0)
    ours = (
        np.stack(
            [Course(perimeter="square", count=2, side_m=4.0, min_distance_m=2.0).draw(rng, far) for _ in range(3000)]
        )
        - 10.0
    )
    drawn = ours[(ours[:, 0] > 0).all(axis=1), 1]
    assert len(drawn) == pytest.approx(750, abs=5 * np.sqrt(750)), "the first is drawn as ever"
    # A coordinate's spread is below 1.2 m on either side.
    np.testing.assert_allclose(drawn.mean(axis=0), expected, atol=4 * 1.2 * np.sqrt(1 / len(drawn) + 1 / allowed.sum()))
    assert (expected < -0.3).all(), "away from the corner"


def test_a_course_without_it_is_drawn_as_it_was_before_there_was_the_option() -> None:
    rng = np.random.default_rng(9)
    square = np.array([10.0, 10.0]) + rng.uniform(-2.5, 2.5, (4, 2))
    length, bearing = rng.uniform(1.0, 12.0, 4), rng.uniform(-np.pi, np.pi, 4)
    legs = START + np.cumsum(np.stack([length * np.cos(bearing), length * np.sin(bearing)], axis=1), axis=0)
    rng = np.random.default_rng(9)
    np.testing.assert_array_equal(Course().draw(rng, START), square)
    np.testing.assert_array_equal(Course(perimeter="legs").draw(rng, START), legs)
    rng = np.random.default_rng(9)
    np.testing.assert_array_equal(Course(perimeter="square").draw(rng, START), square)
    np.testing.assert_array_equal(Course(perimeter="legs").draw(rng, START), legs)


@pytest.mark.parametrize(
    ("course", "field"),
    [
        ({"count": 0}, "count"),
        ({"side_m": 0.0}, "side_m"),
        ({"side_m": np.nan}, "side_m"),
        ({"perimeter": "circle"}, "perimeter"),
        ({"perimeter": "legs", "leg_m": (3.0, 2.0)}, "leg_m"),
        ({"perimeter": "legs", "leg_m": (-1.0, 2.0)}, "leg_m"),
        ({"side_m": 4.0, "min_distance_m": 2.1}, "min_distance_m"),
        ({"perimeter": "disc", "radius_m": 4.0, "min_distance_m": 3.5}, "min_distance_m"),
        ({"min_distance_m": -1.0}, "min_distance_m"),
        ({"min_distance_m": np.nan}, "min_distance_m"),
        ({"perimeter": "legs", "min_distance_m": 1.0}, "min_distance_m"),
        ({"perimeter": "disc", "radius_m": 0.0}, "radius_m"),
        ({"perimeter": "ring", "inner_radius_m": 2.5}, "inner_radius_m"),
        ({"perimeter": "ring", "inner_radius_m": np.nan}, "inner_radius_m"),
        ({"perimeter": "ring"}, "perimeter"),
        ({"cases": (), "count": 3}, "cases"),
        ({"cases": [[[1.0, 2.0]]], "count": 3}, "count"),
    ],
)
def test_what_cannot_be_drawn_is_refused(course: dict[str, object], field: str) -> None:
    with pytest.raises(ValidationError) as caught:
        Course.model_validate(course)
    assert caught.value.errors()[0]["loc"][0] == field
