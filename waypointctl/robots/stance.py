"""Standing still: what the actuators do when no policy drives the robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from waypointctl.robots.robot import Robot

FloatArray = NDArray[np.float64]


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
