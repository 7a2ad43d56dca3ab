"""Domain randomization: latency, masses, friction, gravity and sensor noise, drawn for each robot and episode."""

from __future__ import annotations

import math
from typing import Annotated, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, field_validator

from waypointctl.errors import InputError
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.sim.model import RobotModel

FloatArray: TypeAlias = NDArray[np.float64]
Latency: TypeAlias = Annotated[float, Quantity("s", ge=0, le=1)]
Scale: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=100, allow_inf_nan=False)]
Gravity: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=100, allow_inf_nan=False)]
Angle: TypeAlias = Annotated[float, Quantity("rad", ge=0, le=1)]
Distance: TypeAlias = Annotated[float, Quantity("m", ge=0, le=10)]
Speed: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=100, allow_inf_nan=False)]

# The parameters drawn for an episode, in the order that they are drawn in.
DRAWN: Final = ("latency_s", "mass_factor", "friction_factor", "gravity_mps2")


class SensorNoise(FileModel):
    """Standard deviations of the Gaussian noise of each sensor, drawn anew for each reading."""

    joint_angle_rad: Angle = Field(0.0, description="of each joint")
    joint_speed_radps: Speed = Field(0.0, description="of each joint")
    position_m: Distance = Field(0.0, description="of the base's x, y and z")
    velocity_mps: Speed = Field(0.0, description="of the base's velocity along x, y and z")
    attitude_rad: Angle = Field(0.0, description="of the base's roll, pitch and yaw")
    gyroscope_radps: Speed = Field(0.0, description="of the base's angular velocity about each axis")


class DomainRandomization(FileModel):
    """Values drawn for each robot and episode, uniformly between two bounds; default: the model's values."""

    latency_s: tuple[Latency, Latency] | None = Field(
        None, description="from an action to the motors, in whole physics steps"
    )
    mass_factor: tuple[Scale, Scale] | None = Field(None, description="of all masses and inertias")
    friction_factor: tuple[Scale, Scale] | None = Field(None, description="of the sliding friction of all contacts")
    gravity_mps2: tuple[Gravity, Gravity] | None = Field(None, description="Moon: 1.62, Mars: 3.71")
    sensor_noise: SensorNoise | None = Field(None, description="on the observation, not on reward and progress")

    @field_validator(*DRAWN)
    @classmethod
    def _smallest_first(cls, bounds: tuple[float, float] | None) -> tuple[float, float] | None:
        if bounds is not None and bounds[0] > bounds[1]:
            raise ValueError(f"{list(bounds)}: the smaller bound comes first")
        return bounds

    @property
    def any_drawn(self) -> bool:
        """Whether any value is drawn for an episode."""
        return any(getattr(self, name) is not None for name in DRAWN)

    def values(self, drawn: FloatArray, robot: RobotModel) -> dict[str, FloatArray]:
        """Return the values of k robots, each (k,), by name; without the parameters that do not vary.

        Args:
            drawn: (k, len(DRAWN)) numbers from 0 up to but not including 1, a column for each parameter.
            robot: whose physics steps latencies are whole numbers of.
        """
        values = {}
        for name, share in zip(DRAWN, drawn.T, strict=True):
            bounds: tuple[float, float] | None = getattr(self, name)
            if bounds is not None:
                values[name] = bounds[0] + (bounds[1] - bounds[0]) * share
                if name == "latency_s":
                    low, high = self.latency_steps(robot)
                    values[name] = robot.physics_period_s * (low + np.floor((high - low + 1) * share))
        return values

    def latency_steps(self, robot: RobotModel) -> tuple[int, int]:
        """Return the shortest and the longest latency in the robot's physics steps.

        Raises:
            InputError: one is not a whole number of them.
        """
        low, high = (_whole_steps(bound, robot) for bound in self.latency_s or (0.0, 0.0))
        return low, high


def _whole_steps(latency_s: float, robot: RobotModel) -> int:
    steps = round(latency_s / robot.physics_period_s)
    if not math.isclose(steps * robot.physics_period_s, latency_s, rel_tol=1e-9, abs_tol=1e-9):
        period_ms = 1000 * robot.physics_period_s
        below_ms = period_ms * math.floor(latency_s / robot.physics_period_s)
        raise InputError(
            f"latency: {1000 * latency_s:g} ms is not a whole number of the {robot.name}'s physics steps of "
            f"{period_ms:g} ms; the nearest are {below_ms:g} ms and {below_ms + period_ms:g} ms",
            where="domain_randomization",
        )
    return steps
