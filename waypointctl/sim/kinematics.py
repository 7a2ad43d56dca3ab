"""Where a robot's bodies are, for pictures and viewers."""

from __future__ import annotations

from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.geometry import WORLD, Geom, GeomKind
from waypointctl.sim.model import RobotModel

FloatArray = NDArray[np.float64]

_KINDS: Final[dict[int, GeomKind]] = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_PLANE): "plane",
}


class RobotKinematics:
    """A robot's bodies and shapes. It computes on data of its own: the physics never notices."""

    def __init__(self, robot: RobotModel) -> None:
        """Look at a robot."""
        self._model = robot.model
        self._data = mujoco.MjData(robot.model)
        self.body_names: tuple[str, ...] = tuple(_body_name(self._model, i) for i in range(1, self._model.nbody))
        self.joint_names: tuple[str, ...] = robot.joint_names
        self.geoms: tuple[Geom, ...] = tuple(_geom(self._model, i) for i in range(self._model.ngeom))

    def poses(self, qpos: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bodies' positions (nbody, 3) [m] and quaternions (nbody, 4) w x y z in the world at qpos (nq,).

        The arrays are valid until the next call.
        """
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        return self._data.xpos[1:], self._data.xquat[1:]


def _body_name(model: mujoco.MjModel, index: int) -> str:
    return model.body(index).name or f"body {index}"


def _geom(model: mujoco.MjModel, index: int) -> Geom:
    """Return a shape; what viewers have no shape for, such as a mesh, is the box around it."""
    body, kind = int(model.geom_bodyid[index]), _KINDS.get(int(model.geom_type[index]), "box")
    centre, size = np.zeros(3), model.geom_size[index]
    if int(model.geom_type[index]) not in _KINDS:
        centre, size = model.geom_aabb[index, :3], model.geom_aabb[index, 3:]
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[index])
    x, y, z = (model.geom_pos[index] + rotation.reshape(3, 3) @ centre).tolist()
    qw, qx, qy, qz = model.geom_quat[index].tolist()
    sx, sy, sz = size.tolist()
    r, g, b, a = model.geom_rgba[index].tolist()
    return Geom(
        body=_body_name(model, body) if body else WORLD,
        kind=kind,
        position=(x, y, z),
        quaternion=(qw, qx, qy, qz),
        size=(sx, sy, sz),
        rgba=(r, g, b, a),
    )
