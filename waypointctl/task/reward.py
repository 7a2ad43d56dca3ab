"""What a policy is paid: named terms in units of walking speed, each a pure function of arrays.

The paper's R(G) = V_G - P: velocity towards the current waypoint, less penalties. The terms are Roboschool's
(progress, electricity, joint limits, alive), and those that keep a fast ant from flipping over.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.task.body import JOINT_RATE_SCALE, Body

FloatArray = NDArray[np.float64]

JOINT_LIMIT_MARGIN: Final = 0.01  # of the joint's range: within it a joint counts as at its limit


@dataclass(frozen=True, slots=True)
class RewardWeights:
    """The weight of each term; a term with weight 0 is still computed and logged as 0.

    Attributes:
        progress: for each [m/s] of approach to the current waypoint.
        progress_cap_mps: approach faster than this pays no more.
        alive: for each step not fallen.
        power: against mean |action x scaled joint speed|.
        torque: against mean action squared.
        joint_limits: against each joint at its limit.
        tilt: against 1 - up, 0 upright and 2 upside down.
        wobble: against roll rate squared plus pitch rate squared [(rad/s)^2].
        fall: against falling, once.
    """

    progress: float = 1.0
    progress_cap_mps: float = math.inf
    alive: float = 1.0
    power: float = 2.0
    torque: float = 0.1
    joint_limits: float = 0.2
    tilt: float = 0.0
    wobble: float = 0.0
    fall: float = 0.0

    def __post_init__(self) -> None:
        """Refuse weights that are not numbers or would pay for what is meant as a cost."""
        for field in fields(self):
            value = getattr(self, field.name)
            if math.isnan(value) or value < 0:
                raise InputError(f"reward.{field.name}: {value} is not a number >= 0; costs are subtracted as they are")


TERMS: Final = ("progress", "alive", "power", "torque", "joint_limits", "tilt", "wobble", "fall")


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
    terms[:, 5] = -weights.tilt * (1.0 - body.up)
    roll_pitch = body.rates[:, :2]
    terms[:, 6] = -weights.wobble * np.add.reduce(roll_pitch * roll_pitch, axis=1)
    terms[:, 7] = -weights.fall * fell
    return terms
