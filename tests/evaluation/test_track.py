from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from waypointctl.evaluation.rollout import TRACED, Track, is_orbiting, is_stuck

FloatArray = NDArray[np.float64]

PERIOD_NS = 20_000_000
GOAL = np.array([[7.0, -3.0]])


def followed(way: FloatArray) -> Track:
    """Return the track of robots on a way (steps + 1, n, 2), one row each control step."""
    track = Track(way[0], PERIOD_NS)
    for position in way[1:]:
        track.add(position)
    return track


def circle(radius_m: float, turns: float, steps: int) -> FloatArray:
    """Return a way round the goal, (steps + 1, 1, 2)."""
    angle = np.linspace(0.3, 0.3 + 2 * np.pi * turns, steps + 1)
    return GOAL + radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, np.newaxis]


def orbits(way: FloatArray) -> bool:
    return bool(is_orbiting(followed(way).window(np.array([0]), way[-1]), GOAL)[0])


def test_the_window_is_the_last_five_seconds_and_now() -> None:
    way = np.arange(2 * 2 * 703, dtype=np.float64).reshape(703, 2, 2)
    window = followed(way).window(np.array([1]), way[-1, [1]])
    np.testing.assert_array_equal(window[:, 0], [*way[450:701:5, 1], way[702, 1]])


def test_before_five_seconds_the_window_begins_where_the_robot_stood() -> None:
    way = np.arange(2.0 * 21).reshape(21, 1, 2)
    window = followed(way).window(np.array([0]), way[-1])[:, 0]
    np.testing.assert_array_equal(window[-6:], [*way[0:21:5, 0], way[20, 0]])
    np.testing.assert_array_equal(np.unique(window[:-5], axis=0), way[0])


def test_the_way_is_kept_ten_times_a_second_to_the_end_of_the_trial() -> None:
    way = np.random.default_rng(0).normal(size=(40, TRACED + 1, 2))
    track = followed(way)
    np.testing.assert_array_equal(track.trajectory(3, 23, way[23, 3]), [*way[0:21:5, 3], way[23, 3]])
    assert track.trajectory(TRACED - 1, 39, way[39, 0]).shape == (9, 2)


@pytest.mark.parametrize(("turns", "is_orbit"), [(1.1, True), (-2.5, True), (0.9, False), (0.0, False)])
def test_an_orbit_is_more_than_a_full_circle_in_the_window(turns: float, is_orbit: bool) -> None:
    assert orbits(circle(1.0, turns, 250)) == is_orbit


def test_a_circle_before_the_window_is_no_orbit() -> None:
    way = np.concatenate([circle(1.0, 3.0, 500), np.repeat(circle(1.0, 3.0, 500)[-1:], 300, axis=0)])
    assert not orbits(way)
    assert is_stuck(followed(way).window(np.array([0]), way[-1])).tolist() == [True]


def test_a_wide_circle_is_no_orbit() -> None:
    assert orbits(circle(2.9, 1.5, 250))
    assert not orbits(circle(3.1, 1.5, 250))


def test_a_back_and_forth_beside_the_waypoint_is_neither() -> None:
    x = 7.0 + 2.0 * np.sin(np.linspace(0.0, 20.0, 251))
    way = np.stack([x, np.full(251, -2.0)], axis=1)[:, np.newaxis]
    assert not orbits(way)
    assert not is_stuck(followed(way).window(np.array([0]), way[-1]))[0]


@pytest.mark.parametrize(("speed_mps", "stuck"), [(0.15, True), (0.25, False)])
def test_stuck_is_within_half_a_metre_of_the_middle(speed_mps: float, stuck: bool) -> None:
    way = np.zeros((251, 1, 2))
    way[:, 0, 0] = np.linspace(0.0, 5.0 * speed_mps, 251)
    assert is_stuck(followed(way).window(np.array([0]), way[-1])).tolist() == [stuck]
