"""The reward: named terms in units of walking speed, each a pure function of arrays.

The paper's R(G) = V_G - P: velocity towards the current waypoint, less penalties. The terms are Roboschool's
(progress, electricity, joint limits, alive), and those that keep a fast ant from flipping over.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict

from waypointctl.mission.file_model import FileModel
from waypointctl.task.body import JOINT_RATE_SCALE, Body

FloatArray: TypeAlias = NDArray[np.float64]
# A bound that no sound training comes near, and below which float32 does not overflow at the first step.
Cost: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1e6, allow_inf_nan=False)]

JOINT_LIMIT_MARGIN: Final = 0.01  # of the joint's range: within it a joint counts as at its limit


class RewardWeights(FileModel):
    """The weight of each term in units of walking speed; a term with weight 0 is still computed and logged as 0."""

    progress: Cost = Field(1.0, description="for each m/s of approach to the current waypoint")
    progress_cap_mps: Annotated[float, Strict(), Field(gt=0)] = Field(
        math.inf, description="a faster approach pays no more"
    )
    alive: Cost = Field(1.0, description="for each step not fallen")
    power: Cost = Field(2.0, description="against mean |action x scaled joint speed|")
    torque: Cost = Field(0.1, description="against mean action squared")
    joint_limits: Cost = Field(0.2, description="against each joint at its limit")
    orientation_penalty: Cost = Field(0.0, description="against 1 - up: 0 upright, 2 upside down")
    angular_rate_penalty: Cost = Field(
        0.0, description="against roll rate squared plus pitch rate squared, in (rad/s)^2"
    )
    fall: Cost = Field(0.0, description="against falling, once")


TERMS: Final = (
    "progress",
    "alive",
    "power",
    "torque",
    "joint_limits",
    "orientation_penalty",
    "angular_rate_penalty",
    "fall",
)


def progress_speed(before: FloatArray, after: FloatArray, goal: FloatArray, period_s: float) -> FloatArray:
    """Return the speed of approach (n,) to goal (n, 2) in [m/s], from positions before and after (n, 2).

    Both distances are to the same goal, so a waypoint that moves on pays no jump.
    """
    dx, dy = before[:, 0] - goal[:, 0], before[:, 1] - goal[:, 1]
    ex, ey = after[:, 0] - goal[:, 0], after[:, 1] - goal[:, 1]
    return (np.sqrt(dx * dx + dy * dy) - np.sqrt(ex * ex + ey * ey)) / period_s


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Where a joint counts as at its limit: (nu,) [rad]."""

    low: FloatArray
    high: FloatArray

    @classmethod
    def of_range(cls, low: FloatArray, high: FloatArray) -> JointLimits:
        """Return the limits of joints with ranges low to high (nu,), less the margin."""
        margin = JOINT_LIMIT_MARGIN * (high - low)
        return cls(low + margin, high - margin)

    def count(self, joints: FloatArray) -> FloatArray:
        """Return how many joints (n,) of angles (n, nu) are at a limit."""
        at_limit = (joints < self.low) | (joints > self.high)
        count: FloatArray = np.add.reduce(at_limit, axis=1, dtype=np.float64)
        return count


def reward_terms(
    weights: RewardWeights,
    body: Body,
    approach: FloatArray,
    applied: FloatArray,
    at_limit: FloatArray,
    fell: NDArray[np.bool_],
) -> FloatArray:
    """Return the weighted terms (n, len(TERMS)), in the order of TERMS; their sum along the rows is the reward.

    Args:
        weights: of each term.
        body: after the step.
        approach: (n,) speed of approach to the goal of the step [m/s].
        applied: (n, nu) actions as applied.
        at_limit: (n,) joints at their limit.
        fell: (n,) whether the step ended in a fall.
    """
    terms = np.empty((len(approach), len(TERMS)))
    terms[:, 0] = weights.progress * np.minimum(approach, weights.progress_cap_mps)
    terms[:, 1] = weights.alive * ~fell
    mean = 1.0 / applied.shape[1]
    power = np.add.reduce(np.abs(applied * body.joint_rates), axis=1)
    terms[:, 2] = (-weights.power * JOINT_RATE_SCALE * mean) * power
    terms[:, 3] = (-weights.torque * mean) * np.add.reduce(applied * applied, axis=1)
    terms[:, 4] = -weights.joint_limits * at_limit
    terms[:, 5] = -weights.orientation_penalty * (1.0 - body.up)
    roll_pitch = body.rates[:, :2]
    terms[:, 6] = -weights.angular_rate_penalty * np.add.reduce(roll_pitch * roll_pitch, axis=1)
    terms[:, 7] = -weights.fall * fell
    return terms
