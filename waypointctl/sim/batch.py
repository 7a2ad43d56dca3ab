"""Many robots, stepped in one call on all cores."""

from __future__ import annotations

import mjbatch
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.robots import Robot

FloatArray = NDArray[np.float64]


class RobotBatch:
    """N robots, each in a world of its own. Arrays are live views of the N states."""

    def __init__(self, robot: Robot, num_robots: int, threads: int = 0) -> None:
        """Make N worlds, stepped on `threads` threads (0: one a core)."""
        self.robot = robot
        self._batch = mjbatch.Batch(robot.model, num_robots, num_threads=threads)
        self.integration: FloatArray = self._batch.bind("state")  # (n, size of mjSTATE_INTEGRATION)
        self.qpos: FloatArray = self._batch.bind("qpos")  # (n, nq)
        self.qvel: FloatArray = self._batch.bind("qvel")  # (n, nv)
        self._ctrl: FloatArray = self._batch.bind("ctrl")
        self._new = self.integration[0].copy()

    def place(self, ids: NDArray[np.intp], qpos: FloatArray, qvel: FloatArray) -> None:
        """Put the robots `ids` (k,) at qpos (k, nq), qvel (k, nv) with everything else as new, at time 0."""
        self.integration[ids] = self._new
        self.qpos[ids] = qpos
        self.qvel[ids] = qvel

    def step(self, applied: FloatArray) -> None:
        """Hold the motors at applied (n, nu), in [-1, 1], for one control period."""
        self._ctrl[:] = applied
        self._batch.step(nstep=self.robot.substeps)
