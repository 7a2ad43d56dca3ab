"""What of a recipe says how robots differ: latency, masses, friction, gravity, sensors."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, Strict, field_validator

from waypointctl.errors import InputError
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.robots.robot import Robot
from waypointctl.task.sensor_noise import SensorNoise
from waypointctl.task.variation import Variation

Latency: TypeAlias = Annotated[float, Quantity("s", ge=0, le=1)]
Scale: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=100, allow_inf_nan=False)]
Gravity: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=100, allow_inf_nan=False)]
Angle: TypeAlias = Annotated[float, Quantity("rad", ge=0, le=1)]
Distance: TypeAlias = Annotated[float, Quantity("m", ge=0, le=10)]
Speed: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=100, allow_inf_nan=False)]


class SensorNoiseRecipe(FileModel):
    """Standard deviations of what each sensor is off by, drawn anew for each control step."""

    joint_angle_rad: Angle = Field(0.0, description="of each joint")
    joint_speed_radps: Speed = Field(0.0, description="of each joint")
    position_m: Distance = Field(0.0, description="of the torso's x, y and z")
    velocity_mps: Speed = Field(0.0, description="of the torso's velocity along x, y and z")
    attitude_rad: Angle = Field(0.0, description="of the torso's roll, pitch and yaw")
    gyroscope_radps: Speed = Field(0.0, description="of the torso's angular velocity about each axis")


class VariationRecipe(FileModel):
    """What is drawn for each robot and episode, evenly between two bounds; what is left out does not vary."""

    latency_s: tuple[Latency, Latency] | None = Field(
        None, description="from an action to the motors, in whole physics steps of 10 ms"
    )
    mass_factor: tuple[Scale, Scale] | None = Field(None, description="of all masses and inertias")
    friction_factor: tuple[Scale, Scale] | None = Field(None, description="of the sliding friction of all contacts")
    gravity_mps2: tuple[Gravity, Gravity] | None = Field(None, description="1.62 is the Moon's, 3.71 that of Mars")
    sensor_noise: SensorNoiseRecipe | None = Field(None, description="on what the policy sees, not on its reward")

    @field_validator("latency_s", "mass_factor", "friction_factor", "gravity_mps2")
    @classmethod
    def _smallest_first(cls, bounds: tuple[float, float] | None) -> tuple[float, float] | None:
        if bounds is not None and bounds[0] > bounds[1]:
            raise ValueError(f"{list(bounds)}: the smaller bound comes first")
        return bounds

    def variation(self) -> Variation:
        """Return the task's record of it."""
        noise = None if self.sensor_noise is None else SensorNoise(**self.sensor_noise.model_dump())
        return Variation(self.latency_s, self.mass_factor, self.friction_factor, self.gravity_mps2, noise)

    def check(self, robot: Robot) -> None:
        """Check that the robot can be varied like this.

        Raises:
            ValueError: a latency is no whole number of its physics steps.
        """
        try:
            self.variation().latency_steps(robot)
        except InputError as error:
            raise ValueError(error.problem.removeprefix("variation.")) from error
