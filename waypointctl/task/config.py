"""The definition of a task in one record, and what it shares with recipes: domain randomization, failure replay."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, ValidationError, field_validator, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.errors import InputError
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.task.course import Course, Deadline
from waypointctl.task.plugins import Plugin
from waypointctl.task.reward import RewardWeights

if TYPE_CHECKING:
    from waypointctl.robots.robot import Robot
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


class FailureReplay(FileModel):
    """How often a new episode repeats a course that ended in a fall or at its deadline."""

    probability: Annotated[float, Strict(), Field(ge=0, le=1)] = Field(
        0.0,
        description="of an episode to repeat a failed course, if the robot has one; the success rate during training "
        "includes these episodes",
    )
    memory: Annotated[int, Strict(), Field(gt=0, le=256)] = Field(
        8, description="how many failed courses a robot keeps, the latest"
    )
    tries: Annotated[int, Strict(), Field(gt=0, le=65_536)] = Field(
        5, description="how often a failed course is repeated at most; after a success it is removed at once"
    )

    @model_validator(mode="after")
    def _has_a_probability(self) -> Self:
        unused = sorted(self.model_fields_set & {"memory", "tries"})
        if unused and not self.probability:
            error = PydanticCustomError("failure_replay", "needs a 'probability' above 0, such as probability: 0.3")
            raise ValidationError.from_exception_data(
                "failure_replay", [InitErrorDetails(type=error, loc=(name,), input=None) for name in unused]
            )
        return self


@dataclass(frozen=True, slots=True)
class TaskConfig:
    """A waypoint task: the robot, its observation, its reward, its courses, and when a waypoint counts as reached."""

    robot: Robot | Path | str = "ant"  # itself, its folder, or its name
    observation: str | tuple[str, ...] = "egocentric"  # a layout, or the names of groups
    reward: RewardWeights = field(default_factory=RewardWeights)
    course: Course = field(default_factory=Course)
    failure_replay: FailureReplay = field(default_factory=FailureReplay)
    acceptance: Acceptance = field(default_factory=Acceptance)
    deadline: Deadline = field(default_factory=Deadline)
    start: Start = field(default_factory=Start)
    domain_randomization: DomainRandomization = field(default_factory=DomainRandomization)
    plugins: tuple[Plugin, ...] = ()  # that groups and reward terms may come from


def draw_start(start: Start, robot: Robot, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return a physics state to begin in: qpos (nq,) and qvel (nv,)."""
    joints, speeds = len(robot.nominal), len(robot.nominal) + 6
    heading = rng.uniform(-math.pi, math.pi) if start.random_heading else math.radians(start.heading_deg)
    qpos = np.empty(7 + joints)
    qpos[:3] = (*start.position_m, robot.nominal_height_m)
    qpos[3:7] = (math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2))
    qpos[7:] = robot.nominal + rng.uniform(-start.joint_spread_rad, start.joint_spread_rad, joints)
    return qpos, rng.uniform(-start.speed_spread, start.speed_spread, speeds)
