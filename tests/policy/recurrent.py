"""A policy with a state, for tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from waypointctl.policy.protocol import Policy, PolicyState

FloatArray = NDArray[np.float64]


class Recurrent(Policy):
    """Acts on a running mean of what it has seen, each robot on its own, and swings its joints."""

    robot = "ant"
    observation_layout = "egocentric"

    def __init__(self) -> None:
        rng = np.random.default_rng(5)
        self._into, self._out = rng.normal(0.0, 0.4, (31, 6)), rng.normal(0.0, 0.5, (6, 8))
        self._hidden, self._steps = np.zeros((0, 6)), np.zeros(0, np.int64)

    def reset(self, mask: NDArray[np.bool_]) -> None:
        if len(mask) != len(self._steps):
            self._hidden, self._steps = np.zeros((len(mask), 6)), np.zeros(len(mask), np.int64)
        self._hidden[mask], self._steps[mask] = 0.0, 0

    def act(self, observation: FloatArray) -> FloatArray:
        # Row by row, so that a robot's action is the same bits whoever else there is.
        seen = np.stack([np.tanh(row @ self._into) for row in observation])
        self._hidden = 0.9 * self._hidden + 0.1 * seen
        self._steps += 1
        acted = np.stack([row @ self._out for row in self._hidden])
        swung: FloatArray = 0.1 * (acted + np.sin(0.3 * self._steps)[:, np.newaxis])
        return swung

    def state(self) -> PolicyState:
        return {"hidden": self._hidden.copy(), "steps": self._steps.copy()}

    def restore(self, state: PolicyState) -> None:
        self._hidden, self._steps = state["hidden"].copy(), state["steps"].copy()
