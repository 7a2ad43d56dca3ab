"""Sensors that are off by a little: Gaussian noise on what a policy sees of its body."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.task.body import Body

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SensorNoise:
    """Standard deviations of what each sensor is off by, drawn anew for each reading.

    Attributes:
        joint_angle_rad: of each joint's angle.
        joint_speed_radps: of each joint's speed.
        position_m: of the torso's x, y and z.
        velocity_mps: of the torso's velocity along x, y and z.
        attitude_rad: of the torso's roll, pitch and yaw.
        gyroscope_radps: of the torso's angular velocity about each of its axes.
    """

    joint_angle_rad: float = 0.0
    joint_speed_radps: float = 0.0
    position_m: float = 0.0
    velocity_mps: float = 0.0
    attitude_rad: float = 0.0
    gyroscope_radps: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no standard deviation."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"variation.sensor_noise.{field.name}: {value} is not a standard deviation >= 0")


class NoisySensors:
    """The sensors of a batch of robots.

    All robots read from one stream, row by row: a generator for each would take longer than the physics. So what
    robot i sees depends on how many robots there are, and on which began a new episode when; the same batch with the
    same seed sees the same. A reading takes as many numbers from the stream whichever sensors are noisy.
    """

    def __init__(self, noise: SensorNoise, num_joints: int, rng: np.random.Generator) -> None:
        """Make the sensors of robots with `num_joints` joints, which draw from rng."""
        self.rng = rng
        torso = (noise.position_m, noise.velocity_mps, noise.gyroscope_radps, noise.attitude_rad)
        joints = (noise.joint_angle_rad, noise.joint_speed_radps)
        self._deviation: FloatArray = np.concatenate([np.repeat(torso, 3), np.repeat(joints, num_joints)])
        self._joint_speeds = 12 + num_joints

    def read(self, body: Body) -> Body:
        """Return the bodies (n) as the sensors give them; `body` itself stays as it is.

        Roll and yaw stay within half a turn. `up` follows from roll and pitch.
        """
        off = self.rng.standard_normal((len(body.up), len(self._deviation))) * self._deviation
        roll, pitch = _within_half_a_turn(body.roll + off[:, 9]), body.pitch + off[:, 10]
        return replace(
            body,
            position=body.position + off[:, 0:3],
            velocity=body.velocity + off[:, 3:6],
            rates=body.rates + off[:, 6:9],
            roll=roll,
            pitch=pitch,
            yaw=_within_half_a_turn(body.yaw + off[:, 11]),
            up=np.cos(roll) * np.cos(pitch),
            joints=body.joints + off[:, 12 : self._joint_speeds],
            joint_rates=body.joint_rates + off[:, self._joint_speeds :],
        )


def _within_half_a_turn(angle: FloatArray) -> FloatArray:
    """Return angles (n,) in [-pi, pi]; one that is there already stays as it is, to the last bit."""
    over = np.abs(angle) > math.pi
    return np.where(over, np.remainder(angle + math.pi, 2 * math.pi) - math.pi, angle)
