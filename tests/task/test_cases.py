from __future__ import annotations

import numpy as np

from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig
from waypointctl.task.course import Course
from waypointctl.task.env import WaypointEnv

COURSES = (((10.0, 10.0),), ((7.0, 12.0), (14.0, 14.0)), ((1.0, 0.0), (2.0, 0.0), (3.0, 0.0)))


def course(*weights: float) -> Course:
    """Return the choice of COURSES."""
    cases = zip(COURSES, weights or (1.0, 1.0, 1.0), strict=True)
    return Course.model_validate({"cases": [{"waypoints": points, "weight": weight} for points, weight in cases]})


def shares(cases: Course, draws: int) -> list[float]:
    """Return how often each course was drawn."""
    rng = np.random.default_rng(0)
    drawn = [tuple(map(tuple, cases.draw(rng, np.array([5.0, 5.0])).tolist())) for _ in range(draws)]
    assert set(drawn) <= set(COURSES)
    return [drawn.count(course) / draws for course in COURSES]


def test_each_course_is_drawn_alike() -> None:
    np.testing.assert_allclose(shares(course(), 3000), 1 / 3, atol=5 * np.sqrt(2 / 9 / 3000))


def test_a_course_is_drawn_as_often_as_its_weight_says() -> None:
    np.testing.assert_allclose(shares(course(1.0, 6.0, 3.0), 3000), [0.1, 0.6, 0.3], atol=0.045)


def test_single_point_training_always_goes_to_the_one_point() -> None:
    env = BatchedWaypointEnv(TaskConfig(course=Course.model_validate({"cases": [[[10.0, 10.0]]]})), 5, 0, threads=1)
    env.reset()
    assert env.progress.count.tolist() == [1] * 5
    np.testing.assert_array_equal(env.progress.goals, np.full((5, 2, 2), 10.0))


def test_courses_of_different_lengths_are_walked_side_by_side() -> None:
    env = BatchedWaypointEnv(TaskConfig(course=course()), 60, 0, threads=1)
    env.reset()
    assert set(env.progress.count.tolist()) == {1, 2, 3}
    for waypoints, count in zip(env.progress.waypoints, env.progress.count, strict=True):
        assert tuple(map(tuple, waypoints[:count].tolist())) in COURSES


def test_one_robots_env_tells_the_course_without_what_is_behind_its_end() -> None:
    env = WaypointEnv(TaskConfig(course=course()))
    env.reset(seed=0)
    told = {len(env.reset()[1]["waypoints"]) for _ in range(20)}
    assert told == {1, 2, 3}
