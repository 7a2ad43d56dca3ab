"""Progress along the courses: the paper's Algorithm 1 for many robots at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from waypointctl.mission.fields import Acceptance
from waypointctl.task.course import Deadline
from waypointctl.units import ns

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


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
