"""What actuators are given for an action."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def clip_actions(actions: FloatArray) -> FloatArray:
    """Return actions (n, nu) within [-1, 1], which is all that a robot takes."""
    return np.minimum(np.maximum(actions, -1.0), 1.0)


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
