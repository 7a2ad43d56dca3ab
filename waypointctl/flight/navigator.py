"""The navigator on board: from the robot's pose and its plan to the goals that the policy observes.

The executive decides which waypoint is current and when it is reached. The navigator decides which places the policy
drives to on the way there. `DirectNavigator` gives it the waypoints themselves; a planner that leads the robot around
obstacles gives it places of its own. `fly(..., navigator=...)` takes any object of this protocol.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.task.view import Body

FloatArray = NDArray[np.float64]


class Navigator(Protocol):
    """Gives the policy its current and its next goal, once in each control step in which the policy has the motors.

    It is deterministic: the same calls since the same state give the same goals.
    """

    def goals(self, body: Body, waypoints: FloatArray) -> FloatArray:
        """Return the policy's current and next goal, (1, 2, 2) [m] in the world frame.

        Args:
            body: the robot's pose and velocities.
            waypoints: the plan's current waypoint and the one after it, (1, 2, 2) [m]; the same place twice where the
                robot is to stop at the current one. It is not to be changed.
        """

    def state(self) -> Mapping[str, object]:
        """Return all that later goals depend on besides the arguments, for JSON; empty for one that keeps nothing."""


def sound_goals(goals: FloatArray) -> FloatArray:
    """Return what a navigator gave.

    Raises:
        InputError: it is no array of the shape (1, 2, 2), or has a number that is not finite.
    """
    if (shape := np.shape(goals)) != (1, 2, 2):
        raise InputError(f"the navigator's goals have the shape {shape}, not (1, 2, 2)")
    if not np.isfinite(goals).all():
        raise InputError("the navigator's goals have a number that is not finite")
    return goals


class DirectNavigator:
    """Straight to the waypoint: the policy's goals are the plan's waypoints."""

    def goals(self, body: Body, waypoints: FloatArray) -> FloatArray:
        """Return the waypoints."""
        return waypoints

    def state(self) -> Mapping[str, object]:
        """Return nothing: it keeps none."""
        return {}
