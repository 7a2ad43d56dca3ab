"""How high a robot's feet are above the ground, for many robots at once, from their positions alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.model import RobotModel

FloatArray: TypeAlias = NDArray[np.float64]


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
