"""Where a robot's bodies are, for pictures and viewers."""

from __future__ import annotations

from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.geometry import WORLD, Geom, GeomKind
from waypointctl.sim.robots import Robot

FloatArray = NDArray[np.float64]

_KINDS: Final[dict[int, GeomKind]] = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_PLANE): "plane",
}


class RobotKinematics:
    """A robot's bodies and shapes. It computes on data of its own: the physics never notices."""

    def __init__(self, robot: Robot) -> None:
        """Look at a robot."""
        self._model = robot.model
        self._data = mujoco.MjData(robot.model)
        self.body_names: tuple[str, ...] = tuple(self._model.body(i).name for i in range(1, self._model.nbody))
        self.joint_names: tuple[str, ...] = robot.joint_names
        self.geoms: tuple[Geom, ...] = tuple(_geom(self._model, i) for i in range(self._model.ngeom))

    def poses(self, qpos: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bodies' positions (nbody, 3) [m] and quaternions (nbody, 4) w x y z in the world at qpos (nq,).

        The arrays are valid until the next call.
        """
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        return self._data.xpos[1:], self._data.xquat[1:]


def _geom(model: mujoco.MjModel, index: int) -> Geom:
    body = int(model.geom_bodyid[index])
    x, y, z = model.geom_pos[index].tolist()
    qw, qx, qy, qz = model.geom_quat[index].tolist()
    sx, sy, sz = model.geom_size[index].tolist()
    r, g, b, a = model.geom_rgba[index].tolist()
    return Geom(
        body=model.body(body).name if body else WORLD,
        kind=_KINDS[int(model.geom_type[index])],
        position=(x, y, z),
        quaternion=(qw, qx, qy, qz),
        size=(sx, sy, sz),
        rgba=(r, g, b, a),
    )
