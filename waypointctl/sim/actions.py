"""Actions: checked, clipped, and what actuators are given for them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError

FloatArray = NDArray[np.float64]

_ACTION_HINT: Final = "An action is a number from -1 to 1 for each actuator; robot.yaml says what it means."


def clip_actions(actions: FloatArray) -> FloatArray:
    """Return actions (n, nu) within [-1, 1], which is all that a robot takes."""
    return np.minimum(np.maximum(actions, -1.0), 1.0)


def refuse_bad_action(action: object, num_joints: int, num_robots: int | None = None) -> FloatArray:
    """Return an action (nu,), or actions (n, nu), as float64.

    Args:
        action: what was given.
        num_joints: nu.
        num_robots: n; None: one action.

    Raises:
        InputError: it is not numbers, has another shape, or a number that is not finite.
    """
    shape = (num_joints,) if num_robots is None else (num_robots, num_joints)
    what = "the action" if num_robots is None else "the actions"
    try:
        numbers = np.asarray(action)
        actions: FloatArray = numbers.astype(np.float64, casting="same_kind" if numbers.dtype.kind in "fc" else "safe")
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} must be real numbers: {error}") from error
    if actions.shape != shape:
        raise InputError(f"{what} must have the shape {shape}, not {actions.shape}", hint=_ACTION_HINT)
    if not np.isfinite(actions).all():
        place = np.argwhere(~np.isfinite(actions))[0]
        where = f"joint {place[-1]}" + ("" if num_robots is None else f" of robot {place[0]}")
        raise InputError(f"{what} must be finite: {where} is {actions[tuple(place)]}", hint=_ACTION_HINT)
    return actions


@dataclass(frozen=True, eq=False)
class ActionTransform:
    """Makes the actuators' controls of an action: offset + scale * action, within low and high.

    All are (nu,), in each actuator's own unit: what its MJCF takes for a motor, [rad] for a position servo, [rad/s] for
    a velocity servo.
    """

    scale: FloatArray
    offset: FloatArray
    low: FloatArray
    high: FloatArray

    @cached_property
    def is_plain(self) -> bool:
        """Whether an action is the control as it is."""
        plain = (self.scale == 1.0) & (self.offset == 0.0) & (self.low <= -1.0) & (self.high >= 1.0)
        return bool(plain.all())

    def control(self, applied: FloatArray) -> FloatArray:
        """Return the controls (n, nu) for actions (n, nu) within [-1, 1]."""
        if self.is_plain:
            return applied
        return np.minimum(np.maximum(self.offset + self.scale * applied, self.low), self.high)
