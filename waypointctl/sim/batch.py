"""Many robots, stepped in one call on all cores."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

import mjbatch
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.model import RobotModel

FloatArray = NDArray[np.float64]
Ids = NDArray[np.intp]


MOST_THREADS: Final = 8  # by default; a control step of some hundred robots is too short to be shared by more

_QUOTA: Final = Path("/sys/fs/cgroup/cpu.max")  # of a container: microseconds of processor time, of each period


def default_threads() -> int:
    """Return the default number of threads for a batch: one for each core that this process may use, 8 at most."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    try:
        quota, period = _QUOTA.read_text().split()
        cores = min(cores, int(quota) // int(period))
    except (OSError, ValueError):  # no container, or no limit: "max"
        pass
    return max(1, min(cores, MOST_THREADS))


class RobotBatch:
    """N robots in separate simulations. Arrays are views of the N states and change with them.

    All begin with the model's masses, friction and gravity; `scale_mass`, `scale_friction` and `set_gravity` change
    those of some robots, which costs the others nothing until the first call.
    """

    def __init__(self, robot: RobotModel, num_robots: int, threads: int = 0) -> None:
        """Make N worlds, stepped on `threads` threads (0: `default_threads()`); the states do not depend on it."""
        self.robot = robot
        self._batch = mjbatch.Batch(robot.model, num_robots, num_threads=threads or default_threads())
        self.integration: FloatArray = self._batch.bind("state")  # (n, size of mjSTATE_INTEGRATION)
        self.qpos: FloatArray = self._batch.bind("qpos")  # (n, nq)
        self.qvel: FloatArray = self._batch.bind("qvel")  # (n, nv)
        self._ctrl: FloatArray = self._batch.bind("ctrl")
        self.stepped: NDArray[np.bool_] | None = None  # (n,) the robots that a step moves; None: all of them
        self._new = self.integration[0].copy()

    def place(self, ids: Ids, qpos: FloatArray, qvel: FloatArray) -> None:
        """Put the robots `ids` (k,) at qpos (k, nq), qvel (k, nv) with everything else as new, at time 0."""
        self.integration[ids] = self._new
        self.qpos[ids] = qpos
        self.qvel[ids] = qvel

    def step(self, applied: FloatArray) -> None:
        """Apply actions (n, nu), in [-1, 1], for one control period."""
        self._ctrl[:] = self.robot.actions.control(applied)
        self._batch.step(self.stepped, nstep=self.robot.substeps)

    def step_physics(self, applied: FloatArray) -> None:
        """Apply actions (n, nu), in [-1, 1], for one physics step."""
        self._ctrl[:] = self.robot.actions.control(applied)
        self._batch.step(self.stepped, nstep=1)

    def scale_mass(self, ids: Ids, factor: FloatArray) -> None:
        """Give the robots `ids` (k,) `factor` (k,) times the model's masses and inertias, in all their bodies.

        Armature and damping are the motors' and stay. What follows from the masses is computed anew (mj_setConst).
        """
        model = self.robot.model
        self._batch.expand("body_mass")[ids] = model.body_mass * factor[:, np.newaxis]
        self._batch.expand("body_inertia")[ids] = model.body_inertia * factor[:, np.newaxis, np.newaxis]
        self._batch.set_const(np.unique(ids))

    def scale_friction(self, ids: Ids, factor: FloatArray) -> None:
        """Give the robots `ids` (k,) `factor` (k,) times the model's sliding friction, with all they touch."""
        # MuJoCo takes the larger of two touching geoms' friction, so the ground's has to change as well.
        sliding = self.robot.model.geom_friction[:, 0]
        self._batch.expand("geom_friction")[ids, :, 0] = sliding * factor[:, np.newaxis]

    def set_gravity(self, ids: Ids, gravity_mps2: FloatArray) -> None:
        """Let the robots `ids` (k,) fall with gravity_mps2 (k,), straight down."""
        down = np.array([0.0, 0.0, -1.0])
        self._batch.expand("gravity")[ids] = gravity_mps2[:, np.newaxis] * down
