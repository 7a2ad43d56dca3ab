"""What a flight needs of a policy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Policy(Protocol):
    """A deterministic map from observations to actions."""

    @property
    def robot(self) -> str:
        """The robot it was trained for."""

    @property
    def observation_layout(self) -> str:
        """The observation layout it was trained on, by name."""

    @property
    def reward_weights(self) -> Mapping[str, float]:
        """What it was paid in training, by term: a flight is paid the same."""

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return actions of shape (n, nu), before clipping to [-1, 1], for observations of shape (n, k)."""
