"""The oracle: a robot in a world stepped by nothing but mj_step, on a model of its own."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.robots.load import load_robot

FloatArray = NDArray[np.float64]

INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION


class BareWorld:
    """MuJoCo's own model and data."""

    def __init__(self, model: mujoco.MjModel | None = None) -> None:
        self.model = model or mujoco.MjModel.from_xml_string(load_robot("ant").files["ant.xml"].decode())
        self.data = mujoco.MjData(self.model)

    def place(self, qpos: FloatArray, qvel: FloatArray) -> None:
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = qpos
        self.data.qvel[:] = qvel

    def step(self, applied: FloatArray) -> None:
        self.data.ctrl[:] = applied
        for _ in range(2):
            mujoco.mj_step(self.model, self.data)

    @property
    def integration(self) -> FloatArray:
        state = np.empty(mujoco.mj_stateSize(self.model, INTEGRATION))
        mujoco.mj_getState(self.model, self.data, state, INTEGRATION)
        return state


def random_start(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return a qpos (15,) and qvel (14,) of an ant near its stance, heading anywhere."""
    heading = rng.uniform(-np.pi, np.pi)
    quaternion = [np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)]
    joints = np.deg2rad([0.0, 45.0] * 4) + rng.uniform(-0.2, 0.2, 8)
    return np.array([*rng.uniform(-5, 5, 2), 0.5, *quaternion, *joints]), rng.uniform(-0.5, 0.5, 14)
