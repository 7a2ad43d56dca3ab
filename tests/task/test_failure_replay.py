from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError

from waypointctl.mission.fields import Acceptance, Start
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import FailureReplay, TaskConfig
from waypointctl.task.course import Course, Deadline
from waypointctl.task.env import WaypointEnv

ROBOTS = 16

# Every episode is over after two control steps, too early for its far waypoints.
HOPELESS = TaskConfig(
    course=Course(perimeter="legs", count=2, leg_m=(5.0, 9.0)), deadline=Deadline(first_s=0.04, further_s=1.0)
)

# Episodes end soon and in every way: falls, deadlines and successes.
BUSY = TaskConfig(
    course=Course(perimeter="legs", count=2, leg_m=(0.1, 0.7)),
    failure_replay=FailureReplay(probability=0.5, memory=3, tries=3),
    acceptance=Acceptance(shape="radius", size_m=0.45),
    deadline=Deadline(first_s=0.5, further_s=0.2),
    start=Start(random_heading=True, joint_spread_rad=0.3, speed_spread=1.5),
)


def actions(robots: int, step: int) -> NDArray[np.float64]:
    """Return wild torques (robots, 8); a robot's own, however many there are."""
    wild = [np.random.default_rng((robot, step // 10)).uniform(-1, 1, 8) for robot in range(robots)]
    return 2.5 * np.stack(wild)


def walk(env: BatchedWaypointEnv, steps: int) -> list[list[tuple[bytes, str]]]:
    """Return, for each robot, its courses and how each ended: "walked", "fell" or "late"."""
    episodes: list[list[tuple[bytes, str]]] = [[] for _ in range(env.num_robots)]
    env.reset()
    for number in range(steps):
        courses = [course_of(env, robot) for robot in range(env.num_robots)]
        step = env.step(actions(env.num_robots, number) if env.config is BUSY else np.zeros((env.num_robots, 8)))
        for robot in step.ended:
            end = "walked" if step.success[robot] else "fell" if step.terminated[robot] else "late"
            episodes[robot].append((courses[robot], end))
    return episodes


def course_of(env: BatchedWaypointEnv, robot: int) -> bytes:
    return env.progress.waypoints[robot, : env.progress.count[robot]].tobytes()


@dataclass
class Diary:
    """The oracle: what a robot may walk again, kept as one would on paper."""

    memory: int
    tries: int
    failed: list[bytes] = field(default_factory=list)  # the oldest first
    in_vain: Counter[bytes] = field(default_factory=Counter)
    seen: set[bytes] = field(default_factory=set)
    repeated: int = 0

    def note(self, course: bytes, end: str) -> None:
        again = course in self.seen
        if again:
            assert course in self.failed, "only what failed, lately, and was not walked since, is walked again"
            self.repeated += 1
            self.in_vain[course] += 1
            if end == "walked" or self.in_vain[course] == self.tries:
                self.failed.remove(course)
        elif end != "walked":
            self.failed = [*self.failed, course][-self.memory :]
        self.seen.add(course)


def test_what_is_walked_again_failed_lately_and_was_not_walked_since() -> None:
    env = BatchedWaypointEnv(BUSY, ROBOTS, 1, threads=1)
    ends: Counter[str] = Counter()
    repeated = 0
    for robot, episodes in enumerate(walk(env, 400)):
        diary = Diary(memory=3, tries=3)
        for course, end in episodes:
            diary.note(course, end)
        ends.update(end for _, end in episodes)
        repeated += diary.repeated
        assert env.failed is not None
        size = env.failed.size[robot]
        assert [course.tobytes() for course in env.failed.waypoints[robot, :size]] == diary.failed
    assert min(ends.values()) > 20
    assert len(ends) == 3
    assert repeated > 50


def test_failed_courses_are_as_large_a_share_as_asked() -> None:
    task = replace(HOPELESS, failure_replay=FailureReplay(probability=0.3, memory=50, tries=1000))
    env = BatchedWaypointEnv(task, 60, 2, threads=1)
    episodes = [[course for course, _ in robot] for robot in walk(env, 80)]
    later = [course in robot[:number] for robot in episodes for number, course in enumerate(robot) if number]
    assert len(later) == 60 * 39
    assert np.mean(later) == pytest.approx(0.3, abs=5 * np.sqrt(0.3 * 0.7 / len(later)))


def test_every_failed_course_is_as_likely_as_the_others() -> None:
    task = replace(HOPELESS, failure_replay=FailureReplay(probability=0.5, memory=4, tries=1000))
    ages: Counter[int] = Counter()
    for robot in walk(BatchedWaypointEnv(task, 40, 3, threads=1), 100):
        latest: list[bytes] = []
        for course, _ in robot:
            if course not in latest:
                latest = [*latest, course][-4:]
            elif len(latest) == 4:
                ages[latest.index(course)] += 1
    total = sum(ages.values())
    assert total > 500
    np.testing.assert_allclose([ages[age] / total for age in range(4)], 0.25, atol=5 * np.sqrt(3 / 16 / total))


def test_a_course_is_given_up_after_so_many_tries() -> None:
    task = replace(HOPELESS, failure_replay=FailureReplay(probability=0.9, memory=50, tries=2))
    for robot in walk(BatchedWaypointEnv(task, 10, 4, threads=1), 120):
        times = Counter(course for course, _ in robot)
        assert max(times.values()) == 1 + 2


def test_with_certainty_only_what_never_failed_is_new() -> None:
    task = replace(HOPELESS, failure_replay=FailureReplay(probability=1.0, memory=1, tries=1000))
    for robot in walk(BatchedWaypointEnv(task, 5, 5, threads=1), 40):
        assert len({course for course, _ in robot}) == 1


def test_the_start_is_drawn_anew_and_from_the_stream_it_always_was() -> None:
    def second_start(task: TaskConfig) -> NDArray[np.float64]:
        env = BatchedWaypointEnv(replace(task, start=Start(random_heading=True)), 5, 6, threads=1)
        first = env.reset()
        for _ in range(2):
            observation = env.step(np.zeros((5, 8))).observation
        assert not np.allclose(first, observation)
        return env.batch.qpos.copy()

    again, new = replace(HOPELESS, failure_replay=FailureReplay(probability=1.0)), HOPELESS
    np.testing.assert_array_equal(second_start(again), second_start(new))


@pytest.mark.parametrize(("robots", "threads"), [(1, 1), (5, 2), (ROBOTS, 3)])
def test_a_robot_remembers_the_same_however_many_there_are_and_on_however_many_threads(
    robots: int, threads: int
) -> None:
    expected = walk(BatchedWaypointEnv(BUSY, 5, 7, threads=1), 150)
    there = walk(BatchedWaypointEnv(BUSY, robots, 7, threads=threads), 150)
    for ours, theirs in zip(expected, there, strict=False):
        assert ours == theirs
    assert sum(len(set(robot)) < len(robot) for robot in expected), "some course was walked again"


def test_a_course_that_was_given_is_not_remembered() -> None:
    env = BatchedWaypointEnv(
        replace(HOPELESS, failure_replay=FailureReplay(probability=1.0)), 3, 8, threads=1, autoreset=False
    )
    for _ in range(3):
        env.begin(range(3), np.array([[50.0, 0.0]]))
        for _ in range(4):
            step = env.step(np.zeros((3, 8)))
        assert step.truncated.all()
    assert env.failed is not None
    assert env.failed.size.tolist() == [0, 0, 0]


def test_who_is_left_to_walk_on_failed_once() -> None:
    env = BatchedWaypointEnv(
        replace(HOPELESS, failure_replay=FailureReplay(probability=1.0)), 3, 8, threads=1, autoreset=False
    )
    env.reset()
    for _ in range(6):
        env.step(np.zeros((3, 8)))
    assert env.failed is not None
    assert env.failed.size.tolist() == [1, 1, 1]


def test_courses_of_a_list_keep_their_length() -> None:
    courses = (((5.0, 0.0),), ((5.0, 1.0), (9.0, 9.0)), ((5.0, 2.0), (7.0, 7.0), (9.0, 9.0)))
    task = replace(
        HOPELESS,
        course=Course.model_validate({"cases": [list(course) for course in courses]}),
        failure_replay=FailureReplay(probability=0.5),
    )
    known = {np.array(course).tobytes() for course in courses}
    env = BatchedWaypointEnv(task, 20, 9, threads=1)
    assert {course for robot in walk(env, 40) for course, _ in robot} == known


def test_one_robots_env_forgets_with_a_new_seed() -> None:
    env = WaypointEnv(replace(HOPELESS, failure_replay=FailureReplay(probability=1.0)))
    seen = []
    for _ in range(2):
        course = env.reset(seed=3)[1]["waypoints"]
        for _ in range(2):
            env.step(np.zeros(8, np.float32))
        np.testing.assert_array_equal(env.reset()[1]["waypoints"], course)
        seen.append(course)
    np.testing.assert_array_equal(*seen)
    assert not np.array_equal(env.reset(seed=4)[1]["waypoints"], seen[0])


def test_going_on_from_a_state_is_going_on() -> None:
    def env_after(steps: int) -> BatchedWaypointEnv:
        env = BatchedWaypointEnv(BUSY, ROBOTS, 1, threads=1)
        walk(env, steps)
        return env

    ours, other = env_after(100).failed, env_after(3).failed
    assert ours is not None
    assert other is not None
    other.restore({name: array.copy() for name, array in ours.state().items()})
    for robot in range(ROBOTS):
        for _ in range(10):
            expected, chosen = ours.choose(robot), other.choose(robot)
            assert (chosen is None) == (expected is None)
            if chosen is not None and expected is not None:
                np.testing.assert_array_equal(chosen, expected)
    with pytest.raises(KeyError):
        other.restore({})


@pytest.mark.parametrize(
    "replay",
    [
        {"probability": 1.5},
        {"probability": np.nan},
        {"probability": 0.5, "memory": 0},
        {"probability": 0.5, "tries": 0},
        {"tries": 3},
    ],
)
def test_what_is_no_probability_and_no_number_is_refused(replay: dict[str, float]) -> None:
    with pytest.raises(ValidationError):
        FailureReplay.model_validate(replay)
