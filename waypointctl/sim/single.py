"""One robot, stepped by bare mj_step calls."""

from __future__ import annotations

from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.model import RobotModel

FloatArray = NDArray[np.float64]

_INTEGRATION: Final = mujoco.mjtState.mjSTATE_INTEGRATION


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

    def restore(self, state: FloatArray) -> None:
        """Go back to a state that `integration_state` gave.

        Raises:
            ValueError: the state has another size than this robot's.
        """
        size = mujoco.mj_stateSize(self.robot.model, _INTEGRATION)
        if state.shape != (size,):
            raise ValueError(f"an integration state of {self.robot.name} has {size} numbers, not {state.size}")
        mujoco.mj_setState(self.robot.model, self._data, state, _INTEGRATION)


def integration_components(robot: RobotModel) -> tuple[tuple[str, int], ...]:
    """Return the names and sizes of mjSTATE_INTEGRATION's components, in order.

    MuJoCo's own signature integers move between versions; names and sizes do not.
    """
    bits = [state for state in mujoco.mjtState.__members__.values() if bin(int(state)).count("1") == 1]
    inside = sorted((state for state in bits if int(state) & int(_INTEGRATION)), key=int)
    sizes = ((state.name.removeprefix("mjSTATE_").lower(), mujoco.mj_stateSize(robot.model, state)) for state in inside)
    return tuple((name, size) for name, size in sizes if size)
