from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from waypointctl.mission.fields import Acceptance
from waypointctl.task.course import Deadline
from waypointctl.task.progress import Advance, CourseProgress

FloatArray = NDArray[np.float64]

PERIOD_NS = 20_000_000
FIRST, FURTHER = 500, 1000  # 10 s and 20 s in steps of 20 ms: the paper's Algorithm 1
AWAY = np.array([[-50.0, -50.0]])


def course_of(*waypoints: tuple[float, float], room: int = 4) -> CourseProgress:
    progress = CourseProgress(1, room, Deadline(), PERIOD_NS)
    progress.assign(0, np.array(waypoints))
    return progress


def advance(progress: CourseProgress, position: FloatArray, steps: int = 1) -> Advance:
    for _ in range(steps - 1):
        assert not progress.advance(Acceptance(), position).timed_out.any()
    return progress.advance(Acceptance(), position)


def test_the_first_waypoint_has_ten_seconds() -> None:
    progress = course_of((5.0, 0.0), (9.0, 0.0))
    assert not advance(progress, AWAY, FIRST - 1).timed_out[0]
    assert advance(progress, AWAY).timed_out[0]


def test_each_waypoint_reached_adds_twenty_seconds() -> None:
    progress = course_of((5.0, 0.0), (9.0, 0.0), (9.0, 5.0))
    advance(progress, AWAY, FIRST - 1)
    last_moment = advance(progress, np.array([[5.1, 0.2]]))
    assert last_moment.reached[0]
    assert not last_moment.timed_out[0]
    advance(progress, AWAY, 100)
    assert advance(progress, np.array([[9.0, 0.0]])).reached[0]
    assert not advance(progress, AWAY, FURTHER - 101 + FURTHER - 1).timed_out[0]
    assert advance(progress, AWAY).timed_out[0]


def test_reaching_the_last_waypoint_at_the_last_moment_is_success() -> None:
    progress = course_of((5.0, 0.0))
    advance(progress, AWAY, FIRST - 1)
    end = advance(progress, np.array([[5.0, 0.0]]))
    assert (end.reached[0], end.finished[0], end.timed_out[0]) == (True, True, False)


def test_the_goals_move_on_one_by_one_and_stay_at_the_last() -> None:
    waypoints = ((5.0, 0.0), (9.0, 0.0), (9.0, 5.0))
    progress = course_of(*waypoints, room=6)
    seen = [progress.goals[0].tolist()]
    finished = []
    for waypoint in waypoints:
        step = advance(progress, np.array([waypoint]))
        assert step.reached[0]
        finished.append(bool(step.finished[0]))
        seen.append(progress.goals[0].tolist())
    a, b, c = (list(waypoint) for waypoint in waypoints)
    assert seen == [[a, b], [b, c], [c, c], [c, c]]
    assert finished == [False, False, True]
    assert progress.index[0] == 2


def test_a_waypoint_passed_before_its_turn_does_not_count() -> None:
    progress = course_of((5.0, 0.0), (9.0, 0.0))
    assert not advance(progress, np.array([[9.0, 0.0]])).reached[0]
    assert progress.index[0] == 0


def test_one_step_reaches_one_waypoint_even_where_two_lie_together() -> None:
    progress = course_of((5.0, 0.0), (5.1, 0.0))
    here = np.array([[5.0, 0.0]])
    first, second = advance(progress, here), advance(progress, here)
    assert (first.reached[0], first.finished[0]) == (True, False)
    assert (second.reached[0], second.finished[0]) == (True, True)


def test_many_robots_advance_as_each_does_alone() -> None:
    rng = np.random.default_rng(0)
    courses = [rng.uniform(-3, 3, (rng.integers(1, 6), 2)) for _ in range(20)]
    together = CourseProgress(20, 5, Deadline(first_s=0.4, further_s=0.6), PERIOD_NS)
    alone = [CourseProgress(1, 5, Deadline(first_s=0.4, further_s=0.6), PERIOD_NS) for _ in courses]
    for i, course in enumerate(courses):
        together.assign(i, course)
        alone[i].assign(0, course)
    acceptance, counts = Acceptance(shape="radius", size_m=1.0), np.zeros(3, int)
    for _ in range(120):
        positions = rng.uniform(-3, 3, (20, 2))
        step = together.advance(acceptance, positions)
        for i, progress in enumerate(alone):
            own = progress.advance(acceptance, positions[i : i + 1])
            expected = (own.reached[0], own.finished[0], own.timed_out[0])
            assert (step.reached[i], step.finished[i], step.timed_out[i]) == expected
            assert together.index[i] == progress.index[0]
            np.testing.assert_array_equal(together.goals[i], progress.goals[0])
            counts += expected
            if own.finished[0] or own.timed_out[0]:
                course = rng.uniform(-3, 3, (rng.integers(1, 6), 2))
                together.assign(i, course)
                progress.assign(0, course)
    assert counts.min() > 20, "every outcome was tried"


def test_a_new_course_begins_from_nothing() -> None:
    progress = course_of((5.0, 0.0), (9.0, 0.0))
    advance(progress, np.array([[5.0, 0.0]]), 1)
    progress.assign(0, np.array([[1.0, 1.0]]))
    assert (progress.index[0], progress.steps[0], progress.count[0]) == (0, 0, 1)
    assert progress.goals[0].tolist() == [[1.0, 1.0], [1.0, 1.0]]
    assert not advance(progress, AWAY, FIRST - 1).timed_out[0]
    assert advance(progress, AWAY).timed_out[0]


@pytest.mark.parametrize(("first_s", "steps"), [(0.02, 1), (0.05, 2), (3.0, 150)])
def test_a_deadline_is_counted_in_whole_steps(first_s: float, steps: int) -> None:
    progress = CourseProgress(1, 1, Deadline(first_s=first_s, further_s=1.0), PERIOD_NS)
    progress.assign(0, np.array([[5.0, 5.0]]))
    assert advance(progress, AWAY, steps).timed_out[0]
