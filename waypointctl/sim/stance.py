"""Standing still: what the motors do when no policy has them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.robots import Robot

FloatArray = NDArray[np.float64]


def stance_action(robot: Robot, qpos: FloatArray, qvel: FloatArray) -> FloatArray:
    """Return the action, of shape (n, nu), of a spring and damper at each joint towards the robot's stance.

    A stance needs no goal and no training, so a robot stands the same way whichever policy it carries.

    Args:
        robot: whose stance and gains.
        qpos: (n, nq) [m, quaternion, rad].
        qvel: (n, nv) [m/s, rad/s].
    """
    error = robot.stance - qpos[:, 7:]
    return robot.stance_stiffness * error - robot.stance_damping * qvel[:, 6:]
