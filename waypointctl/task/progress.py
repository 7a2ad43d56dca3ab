"""The courses of many robots: progress along them, the paper's Algorithm 1, and the failed ones, drawn again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.mission.fields import Acceptance
from waypointctl.seeding import restore_streams, stream, streams_words
from waypointctl.task.config import FailureReplay
from waypointctl.task.course import Deadline
from waypointctl.units import ns

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

_NEW: Final = -1  # a course just drawn
_NOT_MINE: Final = -2  # none to keep: it was given, or its episode has ended


def reached(acceptance: Acceptance, position: FloatArray, goal: FloatArray) -> BoolArray:
    """Return which of the positions (n, >= 2) are within acceptance of their goal (n, 2)."""
    dx, dy = position[:, 0] - goal[:, 0], position[:, 1] - goal[:, 1]
    if acceptance.shape == "box":
        return (np.abs(dx) < acceptance.size_m) & (np.abs(dy) < acceptance.size_m)
    return dx * dx + dy * dy < acceptance.size_m**2


@dataclass(frozen=True, slots=True)
class Advance:
    """What one control step changed, for n robots: each (n,) bool."""

    reached: BoolArray  # a waypoint was reached
    finished: BoolArray  # and it was the last
    timed_out: BoolArray  # the deadline passed before the last waypoint


class CourseProgress:
    """The courses of n robots and how far each has come.

    Attributes:
        waypoints: (n, m, 2) in the world frame [m]; a shorter course repeats its last waypoint.
        count: (n,) waypoints of each course.
        index: (n,) the current waypoint of each robot; stays at the last.
        goals: (n, 2, 2) the current waypoint of each robot and the one after it, the same at the last [m].
        steps: (n,) control steps since the course began.
        deadline: (n,) the control step of the deadline.
    """

    def __init__(self, num_robots: int, max_waypoints: int, deadline: Deadline, control_period_ns: int) -> None:
        """Make n empty courses; `assign` them before the first `advance`."""
        self.waypoints: FloatArray = np.zeros((num_robots, max_waypoints, 2))
        self.count: IntArray = np.ones(num_robots, np.int64)
        self.index: IntArray = np.zeros(num_robots, np.int64)
        self.goals: FloatArray = np.zeros((num_robots, 2, 2))
        self.steps: IntArray = np.zeros(num_robots, np.int64)
        self.deadline: IntArray = np.zeros(num_robots, np.int64)
        self._first_steps = ns(deadline.first_s) // control_period_ns
        self._further_steps = ns(deadline.further_s) // control_period_ns

    def assign(self, robot: int, waypoints: FloatArray) -> None:
        """Give one robot a course (m, 2) to begin now."""
        count = len(waypoints)
        self.waypoints[robot, :count] = waypoints
        self.waypoints[robot, count:] = waypoints[-1]
        self.count[robot] = count
        self.index[robot] = 0
        self.steps[robot] = 0
        self.deadline[robot] = self._first_steps
        self.goals[robot] = self.waypoints[robot, [0, min(1, count - 1)]]

    def advance(self, acceptance: Acceptance, position: FloatArray) -> Advance:
        """Count one control step that ended at position (n, >= 2); advance the goals that were reached."""
        self.steps += 1
        there = reached(acceptance, position, self.goals[:, 0])
        finished = np.zeros_like(there)
        if there.any():
            finished = there & (self.index == self.count - 1)
            self._move_on(np.flatnonzero(there), np.flatnonzero(there & ~finished))
        return Advance(reached=there, finished=finished, timed_out=~finished & (self.steps >= self.deadline))

    def _move_on(self, there: NDArray[np.intp], further: NDArray[np.intp]) -> None:
        """Extend the deadline of the robots in `there`, and give those in `further` their next waypoint."""
        self.deadline[there] += self._further_steps
        self.index[further] += 1
        self.goals[further, 0] = self.goals[further, 1]
        following = np.minimum(self.index[further] + 1, self.count[further] - 1)
        self.goals[further, 1] = self.waypoints[further, following]


class FailedCourses:
    """The failed courses of n robots.

    Robot i decides with stream(seed, "retry", i) and keeps only its own failures, so that it does not depend
    on the others. The course is repeated; its start is drawn anew.

    Attributes:
        streams: of each robot.
        waypoints: (n, memory, m, 2) in the world frame [m], the oldest course first.
        count: (n, memory) waypoints of each course.
        tries: (n, memory) how often each was repeated without success.
        size: (n,) courses kept.
        current: (n,) which of them is the current one; negative: none.
    """

    def __init__(self, replay: FailureReplay, num_robots: int, max_waypoints: int, seed: int) -> None:
        """Begin with no failed courses."""
        self.replay = replay
        self.streams = [stream(seed, "retry", i) for i in range(num_robots)]
        self.waypoints: FloatArray = np.zeros((num_robots, replay.memory, max_waypoints, 2))
        self.count: IntArray = np.ones((num_robots, replay.memory), np.int64)
        self.tries: IntArray = np.zeros((num_robots, replay.memory), np.int64)
        self.size: IntArray = np.zeros(num_robots, np.int64)
        self.current: IntArray = np.full(num_robots, _NOT_MINE)

    def choose(self, robot: int) -> FloatArray | None:
        """Return the failed course (m, 2) [m] for a robot's next episode, or None for a new one."""
        rng, size = self.streams[robot], int(self.size[robot])
        again = rng.random() < self.replay.probability and size > 0
        self.current[robot] = slot = int(rng.integers(size)) if again else _NEW
        return self.waypoints[robot, slot, : self.count[robot, slot]].copy() if again else None

    def given(self, robot: int) -> None:
        """Note that a robot's course was given, not drawn: it is not kept if it fails."""
        self.current[robot] = _NOT_MINE

    def ended(self, robots: NDArray[np.intp], success: NDArray[np.bool_], progress: CourseProgress) -> None:
        """Remember or forget the courses of robots (e,) whose episodes ended, in success (e,) or not."""
        for robot, succeeded in zip(robots, success, strict=True):
            slot = self.current[robot]
            # Without autoreset an ended robot is reported in every step; an episode counts once.
            self.current[robot] = _NOT_MINE
            if slot == _NEW and not succeeded:
                self._remember(robot, progress.waypoints[robot, : progress.count[robot]])
            elif slot >= 0:
                self.tries[robot, slot] += 1
                if succeeded or self.tries[robot, slot] >= self.replay.tries:
                    self._forget(robot, slot)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return all arrays needed to continue bit for bit, by name."""
        return {**self._arrays(), "streams": streams_words(self.streams)}

    def restore(self, arrays: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned.

        Raises:
            KeyError, ValueError: it is of other robots, or of another size of memory.
        """
        for name, array in self._arrays().items():
            array[:] = arrays[name]
        restore_streams(self.streams, arrays["streams"])

    def _arrays(self) -> dict[str, NDArray[Any]]:
        return {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}

    def _remember(self, robot: int, course: FloatArray) -> None:
        if self.size[robot] == self.replay.memory:
            self._forget(robot, 0)
        slot = self.size[robot]
        self.waypoints[robot, slot, : len(course)] = course
        self.count[robot, slot] = len(course)
        self.tries[robot, slot] = 0
        self.size[robot] += 1

    def _forget(self, robot: int, slot: int) -> None:
        for of_courses in (self.waypoints[robot], self.count[robot], self.tries[robot]):
            of_courses[slot:-1] = of_courses[slot + 1 :].copy()
        self.size[robot] -= 1
