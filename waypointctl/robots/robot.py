"""A robot: its compiled model, the data of its robot.yaml, its symmetries, and how it stands without a policy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.robots.description import RobotDescription
from waypointctl.sim.model import RobotModel

FloatArray = NDArray[np.float64]

MOST_SYMMETRIES: Final = 48  # of a cube, the most of any body with a few legs
_DIGITS: Final = 6


@dataclass(frozen=True, eq=False)
class Symmetry:
    """A map of a robot's states and actions to those of the same motion, mirrored or turned.

    Attributes:
        name: as robot.yaml has it; of a combination the names in the order in which they are applied.
        frame: (3, 3) the orthogonal matrix that a vector in the base's frame is multiplied by.
        joints: (nj,) for each joint of the image, the joint whose angle it takes.
        signs: (nj,) 1 or -1, what that angle is multiplied by.
    """

    name: str
    frame: FloatArray
    joints: NDArray[np.intp]
    signs: FloatArray

    def of_joints(self, values: FloatArray) -> FloatArray:
        """Return the image of joint angles or speeds (n, nj)."""
        return np.asarray(values[:, self.joints] * self.signs)

    def of_vectors(self, vectors: FloatArray) -> FloatArray:
        """Return the image of vectors (n, 3) in the base's frame: places, velocities, forces."""
        return np.asarray(vectors @ self.frame.T)

    def of_rotations(self, vectors: FloatArray) -> FloatArray:
        """Return the image of angular velocities or torques (n, 3) in the base's frame, which a mirror turns round."""
        return self.of_vectors(vectors) * (1.0 if np.linalg.det(self.frame) > 0 else -1.0)

    def then(self, other: Symmetry) -> Symmetry:
        """Return this symmetry followed by another."""
        return Symmetry(
            name=f"{self.name} {other.name}",
            frame=other.frame @ self.frame,
            joints=self.joints[other.joints],
            signs=self.signs[other.joints] * other.signs,
        )

    @property
    def key(self) -> tuple[bytes, ...]:
        """What distinguishes a symmetry from others."""
        return (np.round(self.frame, _DIGITS) + 0.0).tobytes(), self.joints.tobytes(), self.signs.tobytes()


@dataclass(frozen=True, eq=False, kw_only=True)
class Robot(RobotModel):
    """A robot that is ready to be simulated; `load_robot` makes one.

    Attributes:
        description: robot.yaml.
        files: the files of its folder that it is made of, by their paths in there: robot.yaml, the MJCF, what that
            includes, meshes, textures.
        nominal: (nj,) the joint angles of the nominal pose [rad].
        is_servo: (nu,) whether an action is the target of a servo.
        servo_rest: (nu,) the action at which a servo holds the nominal pose, or a wheel stops; 0 for a motor.
        symmetries: the identity first; only that where robot.yaml names none.
    """

    description: RobotDescription
    files: Mapping[str, bytes]
    nominal: FloatArray
    is_servo: NDArray[np.bool_]
    servo_rest: FloatArray
    symmetries: tuple[Symmetry, ...]

    @property
    def nominal_height_m(self) -> float:
        """Height of the base's origin in the nominal pose [m]."""
        return self.description.nominal.height_m

    @property
    def min_height_m(self) -> float:
        """A robot whose base is lower has fallen [m]."""
        return self.description.termination.min_height_m

    @property
    def min_up(self) -> float:
        """A robot has fallen whose base's upward axis has a smaller vertical part."""
        return self.description.termination.min_up

    @property
    def action_meaning(self) -> str:
        """What the numbers of an action are, in words, for the manifest of a policy."""
        groups = (f"{group.kind} of {', '.join(group.joints)}" for group in self.description.actions)
        return f"{'; '.join(groups)}, in the order of the actuators"

    @property
    def feet(self) -> tuple[str, ...]:
        """The geoms that are meant to touch the ground."""
        return self.description.feet


def stance_action(robot: Robot, qpos: FloatArray, qvel: FloatArray) -> FloatArray:
    """Return the action (n, nu) that holds the robot at its nominal pose.

    A motor acts as a spring and damper at its joint. The servo of a position target holds its offset, and that of a
    velocity target stops. Neither needs a goal or training, so a robot holds in the same way with every policy.

    Args:
        robot: its pose and gains.
        qpos: (n, nq) [m, quaternion, rad].
        qvel: (n, nv) [m/s, rad/s].
    """
    gains, joints = robot.description.stance, robot.actuated
    error = robot.nominal[joints] - qpos[:, 7 + joints]
    action = gains.stiffness * error - gains.damping * qvel[:, 6 + joints]
    if robot.is_servo.any():
        action = np.where(robot.is_servo, robot.servo_rest, action)
    return action


def frame_of(mirror: bool, turn_deg: float) -> FloatArray:
    """Return the matrix (3, 3) of a mirror image (y becomes -y) that is then turned to the left about z."""
    turn_rad = math.radians(turn_deg)
    cos, sin, side = math.cos(turn_rad), math.sin(turn_rad), -1.0 if mirror else 1.0
    return np.array([[cos, -sin * side, 0.0], [sin, cos * side, 0.0], [0.0, 0.0, 1.0]])


def combined(given: Sequence[Symmetry], num_joints: int) -> tuple[Symmetry, ...]:
    """Return the symmetries that some combine to: the identity first, then those given, then the others.

    Raises:
        ValueError: there are more than `MOST_SYMMETRIES`.
    """
    identity = Symmetry("identity", np.eye(3), np.arange(num_joints), np.ones(num_joints))
    found = {identity.key: identity}
    for each in given:
        found.setdefault(each.key, each)
    new = list(found.values())[1:]
    while new:
        images = [one.then(each) for one in new for each in given]
        new = []
        for image in images:
            if image.key not in found:
                found[image.key] = image
                new.append(image)
        if len(found) > MOST_SYMMETRIES:
            raise ValueError(f"they combine to more than {MOST_SYMMETRIES} symmetries")
    return tuple(found.values())
