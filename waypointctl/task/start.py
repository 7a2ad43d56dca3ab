"""How a robot stands when it begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from waypointctl.robots.robot import Robot

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Start:
    """Where a robot begins: standing, but never twice in quite the same way.

    Attributes:
        position_m: of the torso in the world frame.
        heading_rad: of the robot's x axis; None draws one.
        joint_spread_rad: joint angles are off the stance by up to this.
        speed_spread: velocities [m/s, rad/s] are up to this.
    """

    position_m: tuple[float, float] = (0.0, 0.0)
    heading_rad: float | None = 0.0
    joint_spread_rad: float = 0.1
    speed_spread: float = 0.1

    def draw(self, robot: Robot, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """Return a physics state to begin in: qpos (nq,) and qvel (nv,)."""
        joints, speeds = len(robot.nominal), len(robot.nominal) + 6
        heading = rng.uniform(-math.pi, math.pi) if self.heading_rad is None else self.heading_rad
        qpos = np.empty(7 + joints)
        qpos[:3] = (*self.position_m, robot.nominal_height_m)
        qpos[3:7] = (math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2))
        qpos[7:] = robot.nominal + rng.uniform(-self.joint_spread_rad, self.joint_spread_rad, joints)
        return qpos, rng.uniform(-self.speed_spread, self.speed_spread, speeds)
