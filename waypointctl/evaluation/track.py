"""Positions of the robots in an evaluation: enough to classify a time-out, and to draw trajectories."""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.units import NS_PER_S

FloatArray: TypeAlias = NDArray[np.float64]

SAMPLES_PER_S: Final = 10
WINDOW_S: Final = 5  # before the time-out: the window that classifies it
NEAR_M: Final = 3.0  # an orbit stays this near the waypoint
STILL_M: Final = 0.5  # a robot that stays this near the middle of its last positions is stuck
TRACED: Final = 1000  # trials whose whole trajectory is kept


class Track:
    """Positions of n robots, ten times a second: the last seconds of each, all of the first ones."""

    def __init__(self, position: FloatArray, control_period_ns: int) -> None:
        """Begin with the robots at position (n, 2) [m]."""
        self._every = max(1, NS_PER_S // (SAMPLES_PER_S * control_period_ns))  # control steps
        self._steps = 0
        self._window: FloatArray = np.repeat(position[np.newaxis], WINDOW_S * SAMPLES_PER_S + 1, axis=0)
        self._sampled = [position[:TRACED].copy()]

    def add(self, position: FloatArray) -> None:
        """Take where the robots are, (n, 2) [m], after a further control step."""
        self._steps += 1
        if self._steps % self._every == 0:
            self._window[self._slot()] = position
            self._sampled.append(position[:TRACED].copy())

    def window(self, robots: NDArray[np.intp], position: FloatArray) -> FloatArray:
        """Return where robots (k,) were in the last seconds and are now, position (k, 2): (samples, k, 2) [m]."""
        newest_last = np.roll(self._window[:, robots], -self._slot() - 1, axis=0)
        return np.concatenate([newest_last, position[np.newaxis]])

    def trajectory(self, robot: int, steps: int, end: FloatArray) -> FloatArray:
        """Return the trajectory (samples, 2) [m] of one of the TRACED robots, after `steps` steps at `end` (2,)."""
        samples = self._sampled[: steps // self._every + 1]
        return np.array([*(sample[robot] for sample in samples), end])

    def _slot(self) -> int:
        return (self._steps // self._every) % len(self._window)


def is_orbiting(window: FloatArray, goals: FloatArray) -> NDArray[np.bool_]:
    """Return which trajectories (samples, k, 2) [m] circle their goals (k, 2): more than once, and near."""
    offset = window - goals
    bearing = np.unwrap(np.arctan2(offset[..., 1], offset[..., 0]), axis=0)
    near = np.linalg.norm(offset, axis=2).max(axis=0) < NEAR_M
    return np.asarray(near & (np.abs(bearing[-1] - bearing[0]) > 2 * np.pi))


def is_stuck(window: FloatArray) -> NDArray[np.bool_]:
    """Return which trajectories (samples, k, 2) [m] stay in one place."""
    return np.asarray(np.linalg.norm(window - window.mean(axis=0), axis=2).max(axis=0) < STILL_M)
