"""How far along its course each robot is: the paper's Algorithm 1 for many robots at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from waypointctl.task.acceptance import Acceptance, reached
from waypointctl.task.course import Deadline
from waypointctl.units import ns


FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Advance:
    """What one control step changed, for n robots: each (n,) bool."""

    reached: BoolArray  # a waypoint was reached
    finished: BoolArray  # and it was the last
    timed_out: BoolArray  # the deadline passed without


class CourseProgress:
    """The courses of n robots and how far each has come.

    Attributes:
        waypoints: (n, m, 2) in the world frame [m]; a shorter course repeats its last waypoint.
        count: (n,) waypoints of each course.
        index: (n,) the waypoint each robot walks to; stays at the last.
        steps: (n,) control steps since the course began.
        deadline: (n,) the control step at which time runs out.
    """

    def __init__(self, num_robots: int, max_waypoints: int, deadline: Deadline, control_period_ns: int) -> None:
        """Make n empty courses; `assign` them before the first `advance`."""
        self.waypoints: FloatArray = np.zeros((num_robots, max_waypoints, 2))
        self.count: IntArray = np.ones(num_robots, np.int64)
        self.index: IntArray = np.zeros(num_robots, np.int64)
        self.steps: IntArray = np.zeros(num_robots, np.int64)
        self.deadline: IntArray = np.zeros(num_robots, np.int64)
        self._first_steps = ns(deadline.first_s) // control_period_ns
        self._further_steps = ns(deadline.further_s) // control_period_ns
        self._rows = np.arange(num_robots)
        self._columns = self._rows[:, np.newaxis]

    def assign(self, robot: int, waypoints: FloatArray) -> None:
        """Give one robot a course (m, 2) to begin now."""
        count = len(waypoints)
        self.waypoints[robot, :count] = waypoints
        self.waypoints[robot, count:] = waypoints[-1]
        self.count[robot] = count
        self.index[robot] = 0
        self.steps[robot] = 0
        self.deadline[robot] = self._first_steps

    def goals(self) -> FloatArray:
        """Return the current waypoint and the following one, the same again at the last: (n, 2, 2) [m]."""
        following = np.minimum(self.index + 1, self.count - 1)
        return self.waypoints[self._columns, np.stack([self.index, following], axis=1)]

    def advance(self, acceptance: Acceptance, position: FloatArray) -> Advance:
        """Count one control step that ended at position (n, >= 2); move the goals that were reached on."""
        self.steps += 1
        there = reached(acceptance, position, self.waypoints[self._rows, self.index])
        last = self.index == self.count - 1
        finished = there & last
        self.index += there & ~last
        self.deadline += there * self._further_steps
        return Advance(reached=there, finished=finished, timed_out=~finished & (self.steps >= self.deadline))
