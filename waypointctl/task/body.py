"""Pose and velocity of the robot's base and joints, in the frames that the task uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

JOINT_RATE_SCALE: Final = 0.1  # Roboschool's scale for joint speeds, in observations and in the power penalty


@dataclass(frozen=True, slots=True)
class Body:
    """Pose and velocity of n robots, from their physics state.

    Attributes:
        position: (n, 3) of the base in the world frame [m].
        velocity: (n, 3) of the base in the world frame [m/s].
        rates: (n, 3) angular velocity in the body frame, as a gyroscope gives it [rad/s].
        roll: (n,) [rad], with pitch and yaw the z-y-x Euler angles of the base.
        pitch: (n,) [rad].
        yaw: (n,) [rad].
        up: (n,) vertical part of the base's upward axis: 1 upright, -1 upside down.
        joints: (n, nj) joint angles [rad].
        joint_rates: (n, nj) joint speeds [rad/s].
    """

    position: FloatArray
    velocity: FloatArray
    rates: FloatArray
    roll: FloatArray
    pitch: FloatArray
    yaw: FloatArray
    up: FloatArray
    joints: FloatArray
    joint_rates: FloatArray


def body_of(qpos: FloatArray, qvel: FloatArray) -> Body:
    """Return the body of n robots with a floating base. qpos: (n, 7 + nj), qvel: (n, 6 + nj). Arrays are views."""
    w, x, y, z = qpos[:, 3], qpos[:, 4], qpos[:, 5], qpos[:, 6]
    xx, yy = x * x, y * y
    up = 1.0 - 2.0 * (xx + yy)
    return Body(
        position=qpos[:, :3],
        velocity=qvel[:, :3],
        rates=qvel[:, 3:6],
        roll=np.arctan2(2.0 * (w * x + y * z), up),
        pitch=np.arcsin(np.minimum(np.maximum(2.0 * (w * y - z * x), -1.0), 1.0)),
        yaw=np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (yy + z * z)),
        up=up,
        joints=qpos[:, 7:],
        joint_rates=qvel[:, 6:],
    )


def fallen(body: Body, min_height_m: float, min_up: float) -> NDArray[np.bool_]:
    """Return which robots (n,) have fallen: the base is too low, or tilted too far."""
    return (body.position[:, 2] < min_height_m) | (body.up < min_up)
