"""The reward: named terms, each a function of a `SimulationView`, times the weights of a recipe.

The paper's R(G) = V_G - P: velocity towards the current waypoint, less penalties. The terms are Roboschool's
(progress, electricity, joint limits, alive), and those that keep a fast robot from tipping over.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, Strict

from waypointctl.errors import InputError
from waypointctl.mission.file_model import FileModel
from waypointctl.task.plugins import PLUGIN_HINT, Plugin, RewardTerm, by_name
from waypointctl.task.view import JOINT_RATE_SCALE, SimulationView

if TYPE_CHECKING:
    from waypointctl.robots.robot import Robot

FloatArray: TypeAlias = NDArray[np.float64]
# Far above any useful weight, and low enough that float32 does not overflow in the first step.
Cost: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1e6, allow_inf_nan=False)]
Weight: TypeAlias = Annotated[float, Strict(), Field(ge=-1e6, le=1e6, allow_inf_nan=False)]

JOINT_LIMIT_MARGIN: Final = 0.01  # of the joint's range: within it a joint counts as at its limit


class RewardWeights(FileModel):
    """The weight of each term in units of speed; a term with weight 0 is logged as 0.

    Any other key is the name of a plugin's reward term, and may be negative.
    """

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Weight]

    progress: Cost = Field(1.0, description="weight of the speed of approach to the current waypoint [m/s]")
    progress_cap_mps: Annotated[float, Strict(), Field(gt=0)] = Field(
        math.inf, description="largest speed of approach that is rewarded"
    )
    alive: Cost = Field(1.0, description="weight of each control step without a fall")
    power: Cost = Field(2.0, description="penalty weight of the mean of |action x scaled joint speed|")
    torque: Cost = Field(0.1, description="penalty weight of the mean squared action")
    joint_limits: Cost = Field(0.2, description="penalty weight of each joint at its limit")
    orientation_penalty: Cost = Field(0.0, description="penalty weight of 1 - up: 0 upright, 2 upside down")
    angular_rate_penalty: Cost = Field(
        0.0, description="penalty weight of roll rate squared plus pitch rate squared [(rad/s)^2]"
    )
    fall: Cost = Field(0.0, description="penalty of a fall, once")

    @property
    def plugin_terms(self) -> dict[str, float]:
        """The weights of terms that are not built in, by name."""
        return self.__pydantic_extra__


def progress_speed(before: FloatArray, after: FloatArray, goal: FloatArray, period_s: float) -> FloatArray:
    """Return the speed of approach (n,) to goal (n, 2) in [m/s], from positions before and after (n, 2).

    Both distances are to the same goal, so the change to the next waypoint causes no jump.
    """
    dx, dy = before[:, 0] - goal[:, 0], before[:, 1] - goal[:, 1]
    ex, ey = after[:, 0] - goal[:, 0], after[:, 1] - goal[:, 1]
    return (np.sqrt(dx * dx + dy * dy) - np.sqrt(ex * ex + ey * ey)) / period_s


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Where a joint counts as at its limit: (nj,) [rad]."""

    low: FloatArray
    high: FloatArray

    @classmethod
    def of_range(cls, low: FloatArray, high: FloatArray) -> JointLimits:
        """Return the limits of joints with ranges low to high (nj,), minus the margin."""
        margin = np.where(np.isfinite(low) & np.isfinite(high), JOINT_LIMIT_MARGIN * (high - low), 0.0)
        return cls(low + margin, high - margin)

    def count(self, joints: FloatArray) -> FloatArray:
        """Return how many joints (n,) of angles (n, nj) are at a limit."""
        at_limit = (joints < self.low) | (joints > self.high)
        count: FloatArray = np.add.reduce(at_limit, axis=1, dtype=np.float64)
        return count


@cache
def _limits(robot: Robot) -> JointLimits:
    return JointLimits.of_range(robot.joint_low, robot.joint_high)


def _approach(view: SimulationView) -> FloatArray:
    assert view.approach is not None
    return view.approach


def _capped_approach(cap_mps: float, view: SimulationView) -> FloatArray:
    return np.minimum(_approach(view), cap_mps)


def _alive(view: SimulationView) -> NDArray[np.bool_]:
    assert view.fell is not None
    return ~view.fell


def _fall(view: SimulationView) -> NDArray[np.bool_]:
    assert view.fell is not None
    return view.fell


def _power(view: SimulationView) -> FloatArray:
    applied, speeds = view.action, view.body.joint_rates
    if speeds.shape != applied.shape:  # some joints have no actuator
        speeds = speeds[:, view.robot.actuated]
    total: FloatArray = np.add.reduce(np.abs(applied * speeds), axis=1)
    return total * (1.0 / len(applied[0]))


def _torque(view: SimulationView) -> FloatArray:
    applied = view.action
    total: FloatArray = np.add.reduce(applied * applied, axis=1)
    return total * (1.0 / len(applied[0]))


def _roll_pitch_rates(view: SimulationView) -> FloatArray:
    rates = view.body.rates[:, :2]
    squared: FloatArray = np.add.reduce(rates * rates, axis=1)
    return squared


TERMS: Final = (
    RewardTerm("progress", _approach, "m/s", built_in=True),
    RewardTerm("alive", _alive, "1", built_in=True),
    RewardTerm("power", _power, "rad/s", -JOINT_RATE_SCALE, built_in=True),
    RewardTerm("torque", _torque, "1", -1.0, built_in=True),
    RewardTerm("joint_limits", lambda view: _limits(view.robot).count(view.body.joints), "1", -1.0, built_in=True),
    RewardTerm("orientation_penalty", lambda view: 1.0 - view.body.up, "1", -1.0, built_in=True),
    RewardTerm("angular_rate_penalty", _roll_pitch_rates, "(rad/s)^2", -1.0, built_in=True),
    RewardTerm("fall", _fall, "1", -1.0, built_in=True),
)


class RewardFunction:
    """The reward of n robots, term by term.

    Attributes:
        names: of the terms: the built-in ones, then those of plugins in the order of the weights.
    """

    def __init__(self, weights: RewardWeights, plugins: Iterable[Plugin] = ()) -> None:
        """Choose the terms that the weights name.

        Raises:
            InputError: a term is unknown.
        """
        known = by_name(TERMS, (plugin for plugin in plugins if isinstance(plugin, RewardTerm)), "reward term")
        if unknown := [name for name in weights.plugin_terms if name not in known]:
            raise InputError(
                f"unknown reward term {unknown[0]!r}; available: {', '.join(known)}",
                hint=PLUGIN_HINT,
            )
        chosen = [*TERMS, *(known[name] for name in weights.plugin_terms)]
        self.names: tuple[str, ...] = tuple(term.name for term in chosen)
        capped = partial(_capped_approach, weights.progress_cap_mps)
        values = dict(weights)  # not attributes: a plugin's term may be called as a method of the model
        parts = [
            (values[term.name] * term.factor, capped if term.name == "progress" else term.filler()) for term in chosen
        ]
        # A cost is never negative: where its weight is 0 it need not be computed.
        left_out = [values[term.name] == 0.0 and term.factor < 0.0 and term.built_in for term in chosen]
        self._parts = [(column, *part) for column, part in enumerate(parts) if not left_out[column]]
        self._left_out = np.flatnonzero(left_out)

    def terms(self, view: SimulationView) -> FloatArray:
        """Return the weighted terms (n, len(names)); their sum along the rows is the reward."""
        terms = np.empty((len(view.body.up), len(self.names)))
        terms[:, self._left_out] = -0.0
        for column, weight, function in self._parts:
            terms[:, column] = weight * function(view)
        return terms
