"""Where a robot's bodies and feet are: for pictures and viewers, and for many robots at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import mujoco
import numpy as np

from waypointctl.sim.geometry import WORLD, Geom, GeomKind
from waypointctl.sim.model import FloatArray, RobotModel

_KINDS: Final[dict[int, GeomKind]] = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_PLANE): "plane",
}


@dataclass(frozen=True, slots=True)
class _Link:
    """A body of the tree in its parent's frame, with the hinge that turns it; axis (3,), the others as in MuJoCo."""

    parent: int
    position: FloatArray
    rotation: FloatArray
    hinge: tuple[int, FloatArray, FloatArray, float] | None  # place in qpos, axis, anchor [m], zero angle


class Feet:
    """The geoms of a robot that are meant to touch the ground, as its robot.yaml names them.

    Attributes:
        names: of the geoms.
        margins: (k,) [m], a foot that is lower than this is in contact with the ground.
    """

    def __init__(self, robot: RobotModel, names: tuple[str, ...]) -> None:
        """Read the tree of the robot's bodies."""
        model = robot.model
        self.names = names
        self._links = {body: _link(model, body) for body in range(2, model.nbody)}
        geoms = [model.geom(name).id for name in names]
        self._feet = [(int(model.geom_bodyid[geom]), *_corners(model, geom)) for geom in geoms]
        ground = max((float(model.geom_margin[geom]) for geom in range(model.body_geomnum[0])), default=0.0)
        # MuJoCo adds the margins of the two geoms.
        self.margins: FloatArray = np.array([ground + float(model.geom_margin[geom]) for geom in geoms])

    def heights(self, qpos: FloatArray) -> FloatArray:
        """Return the height of each foot's lowest point above the ground (n, k) [m], for qpos (n, nq)."""
        frames = {1: (qpos[:, :3], _rotation(qpos[:, 3:7]))}  # the base
        for body, link in self._links.items():
            position, rotation = frames[link.parent]
            position, rotation = position + rotation @ link.position, rotation @ link.rotation
            if link.hinge is not None:
                place, axis, anchor, zero = link.hinge
                turned = rotation @ _turn(axis, qpos[:, place] - zero)
                position, rotation = position + rotation @ anchor - turned @ anchor, turned
            frames[body] = position, rotation
        heights = np.empty((len(qpos), len(self._feet)))
        for foot, (body, corners, radius) in enumerate(self._feet):
            position, rotation = frames[body]
            heights[:, foot] = position[:, 2] + (rotation[:, 2] @ corners.T).min(axis=1) - radius
        return heights


@cache
def feet_of(robot: RobotModel, names: tuple[str, ...]) -> Feet:
    """Return the feet of a robot, by the names of their geoms."""
    return Feet(robot, names)


def _link(model: mujoco.MjModel, body: int) -> _Link:
    hinge = None
    if model.body_jntnum[body]:
        joint = int(model.body_jntadr[body])
        place = int(model.jnt_qposadr[joint])
        hinge = (place, model.jnt_axis[joint].copy(), model.jnt_pos[joint].copy(), float(model.qpos0[place]))
    rotation = _rotation(model.body_quat[body][np.newaxis])[0]
    return _Link(int(model.body_parentid[body]), model.body_pos[body].copy(), rotation, hinge)


def _corners(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, float]:
    """Return points (m, 3) in the body's frame and a radius around them that together are the geom [m].

    Spheres, capsules and boxes are exact; of another shape it is the box around it.
    """
    rotation = _rotation(model.geom_quat[geom][np.newaxis])[0]
    size, centre, half = model.geom_size[geom], model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    radius = 0.0
    match int(model.geom_type[geom]):
        case kind if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            points, radius = np.zeros((1, 3)), float(size[0])
        case kind if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
            points, radius = np.array([[0.0, 0.0, -size[1]], [0.0, 0.0, size[1]]]), float(size[0])
        case _:
            signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
            points = centre + signs * half
    return model.geom_pos[geom] + points @ rotation.T, radius


def _rotation(quaternion: FloatArray) -> FloatArray:
    """Return rotation matrices (n, 3, 3) of unit quaternions (n, 4), w x y z."""
    w, x, y, z = quaternion.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _turn(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Return the rotations (n, 3, 3) by angles (n,) about a unit axis (3,)."""
    half = angle[:, np.newaxis] / 2
    return _rotation(np.concatenate([np.cos(half), np.sin(half) * axis], axis=1))


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
