"""No two robots are alike: what differs from robot to robot and from episode to episode."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.sim.model import RobotModel
from waypointctl.task.sensor_noise import SensorNoise

FloatArray = NDArray[np.float64]
Range: TypeAlias = tuple[float, float]

# The parameters drawn for an episode, in the order that they are drawn in, and what each is allowed to be.
DRAWN: Final = {
    "latency_s": "a shortest and a longest time >= 0 s",
    "mass_factor": "a smallest and a largest factor > 0",
    "friction_factor": "a smallest and a largest factor > 0",
    "gravity_mps2": "a smallest and a largest value >= 0 m/s^2",
}


@dataclass(frozen=True, slots=True)
class Variation:
    """What is drawn for each robot and episode, evenly between two bounds, and how noisy sensors are.

    None leaves a thing as the robot's model has it.

    Attributes:
        latency_s: from an action to the motors [s], in whole physics steps.
        mass_factor: of all masses and inertias.
        friction_factor: of the sliding friction of all contacts.
        gravity_mps2: [m/s^2], straight down.
        sensor_noise: on what the policy sees; reward and progress are told the truth.
    """

    latency_s: Range | None = None
    mass_factor: Range | None = None
    friction_factor: Range | None = None
    gravity_mps2: Range | None = None
    sensor_noise: SensorNoise | None = None

    def __post_init__(self) -> None:
        """Refuse bounds that nothing can be drawn between."""
        for name, allowed in DRAWN.items():
            bounds: Range | None = getattr(self, name)
            if bounds is not None and not _sound(bounds, zero=name in ("latency_s", "gravity_mps2")):
                raise InputError(f"variation.{name}: {list(bounds)} is not {allowed}")

    @property
    def any_drawn(self) -> bool:
        """Whether an episode has anything to draw."""
        return any(getattr(self, name) is not None for name in DRAWN)

    def values(self, drawn: FloatArray, robot: RobotModel) -> dict[str, FloatArray]:
        """Return what k robots get, each (k,), by its name here; what does not vary is left out.

        Args:
            drawn: (k, len(DRAWN)) numbers from 0 up to but not including 1, a column for each parameter.
            robot: whose physics steps latencies are whole numbers of.
        """
        values = {}
        for name, share in zip(DRAWN, drawn.T, strict=True):
            bounds: Range | None = getattr(self, name)
            if bounds is not None:
                values[name] = bounds[0] + (bounds[1] - bounds[0]) * share
                if name == "latency_s":
                    low, high = self.latency_steps(robot)
                    values[name] = robot.physics_period_s * (low + np.floor((high - low + 1) * share))
        return values

    def latency_steps(self, robot: RobotModel) -> tuple[int, int]:
        """Return the shortest and the longest latency in the robot's physics steps.

        Raises:
            InputError: one is no whole number of them.
        """
        low, high = (_whole_steps(bound, robot) for bound in self.latency_s or (0.0, 0.0))
        return low, high


def _sound(bounds: Range, *, zero: bool) -> bool:
    low, high = bounds
    return math.isfinite(high) and 0 <= low <= high and (zero or low > 0)


def _whole_steps(latency_s: float, robot: RobotModel) -> int:
    steps = round(latency_s / robot.physics_period_s)
    if not math.isclose(steps * robot.physics_period_s, latency_s, rel_tol=1e-9, abs_tol=1e-9):
        period_ms = 1000 * robot.physics_period_s
        below_ms = period_ms * math.floor(latency_s / robot.physics_period_s)
        raise InputError(
            f"variation.latency_s: {1000 * latency_s:g} ms is no whole number of the {robot.name}'s physics steps of "
            f"{period_ms:g} ms; the nearest are {below_ms:g} ms and {below_ms + period_ms:g} ms"
        )
    return steps
