"""Motors that do what they are told a little later."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Ids = NDArray[np.intp]


class ActuatorLatency:
    """What has been commanded of n robots and has not reached their motors yet.

    A robot's latency is a whole number of physics steps, so an action may take effect in the middle of a control
    period. Until the first action of an episode has arrived the motors are off.

    Attributes:
        steps: (n,) latency in physics steps.
        commanded: (n, m, nu) the latest actions, newest first: as many as the longest latency needs.
    """

    def __init__(self, num_robots: int, num_joints: int, substeps: int, longest: int) -> None:
        """Make the queues of robots with no latency yet and `substeps` physics steps in a control period.

        longest: the largest that `steps` will be set to, in physics steps.
        """
        self.steps: IntArray = np.zeros(num_robots, np.int64)
        self.commanded: FloatArray = np.zeros((num_robots, 1 - (-longest // substeps), num_joints))
        self._substeps = substeps
        self._robots = np.arange(num_robots)

    def switch_off(self, ids: Ids) -> None:
        """Forget what has been commanded of the robots `ids` (k,): a new episode begins."""
        self.commanded[ids] = 0.0

    def step(self, actions: FloatArray, step_physics: Callable[[FloatArray], None]) -> FloatArray:
        """Command actions (n, nu) and let one control period pass; return what the motors held at its end (n, nu).

        step_physics: holds the motors at what it is given, (n, nu), for one physics step.
        """
        self.commanded[:, 1:] = self.commanded[:, :-1].copy()
        self.commanded[:, 0] = actions
        held = actions
        for substep in range(self._substeps):
            # The newest action that was commanded at least `steps` physics steps before this one.
            age = (self.steps - substep + self._substeps - 1) // self._substeps
            held = self.commanded[self._robots, age]
            step_physics(held)
        return held
