"""Stepping one robot by bare mj_step calls, or many in one call on all cores."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

import mjbatch
import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.model import FloatArray, RobotModel

Ids = NDArray[np.intp]

MOST_THREADS: Final = 8  # by default; a control step of some hundred robots is too short to be shared by more

_QUOTA: Final = Path("/sys/fs/cgroup/cpu.max")  # of a container: microseconds of processor time, of each period

_INTEGRATION: Final = mujoco.mjtState.mjSTATE_INTEGRATION


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


class SingleRobot:
    """One robot in its world. Arrays have a leading batch dimension of one and follow the simulation."""

    def __init__(self, robot: RobotModel) -> None:
        """Make the world; `place` the robot before the first step."""
        self.robot = robot
        self._data = mujoco.MjData(robot.model)
        self.qpos: FloatArray = self._data.qpos[np.newaxis]
        self.qvel: FloatArray = self._data.qvel[np.newaxis]
        self.qacc_warmstart: FloatArray = self._data.qacc_warmstart[np.newaxis]

    def place(self, qpos: FloatArray, qvel: FloatArray) -> None:
        """Put the robot at qpos (1, nq), qvel (1, nv) with everything else as new, at time 0."""
        mujoco.mj_resetData(self.robot.model, self._data)
        self.qpos[:] = qpos
        self.qvel[:] = qvel

    def step(self, applied: FloatArray) -> None:
        """Apply actions (1, nu), in [-1, 1], for one control period."""
        self._data.ctrl[:] = self.robot.actions.control(applied)[0]
        mujoco.mj_step(self.robot.model, self._data, self.robot.substeps)

    def integration_state(self) -> FloatArray:
        """Return a copy of mjSTATE_INTEGRATION, from which stepping continues bit for bit."""
        state = np.empty(mujoco.mj_stateSize(self.robot.model, _INTEGRATION))
        mujoco.mj_getState(self.robot.model, self._data, state, _INTEGRATION)
        return state


def integration_components(robot: RobotModel) -> tuple[tuple[str, int], ...]:
    """Return the names and sizes of mjSTATE_INTEGRATION's components, in order.

    MuJoCo's own signature integers move between versions; names and sizes do not.
    """
    bits = [state for state in mujoco.mjtState.__members__.values() if bin(int(state)).count("1") == 1]
    inside = sorted((state for state in bits if int(state) & int(_INTEGRATION)), key=int)
    sizes = ((state.name.removeprefix("mjSTATE_").lower(), mujoco.mj_stateSize(robot.model, state)) for state in inside)
    return tuple((name, size) for name, size in sizes if size)
