"""How often a lossy link loses messages on end: the loss model of a mission as a Markov chain, worked out exactly."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.mission.link import Bursts, Loss

FloatArray = NDArray[np.float64]

_EXACTLY: Final = 5_000  # messages that are worked out one by one; from then on each is as risky as the last
_MOST_SUMS: Final = 5_000_000  # messages times length of the run


class Chain:
    """A link that is good or bad, and may change with each message. One that loses at random is always good.

    Attributes:
        step: (2, 2), from good and bad to good and bad with each message.
        lost: (2,), the probability that a message is lost while the link is good, and while it is bad.
    """

    def __init__(self, loss: Loss) -> None:
        """Take the loss of a mission's link."""
        bursts = loss if isinstance(loss, Bursts) else Bursts(p=0.0, r=1.0, one_minus_h=1.0, one_minus_k=loss)
        self.step: FloatArray = np.array([[1 - bursts.p, bursts.p], [bursts.r, 1 - bursts.r]])
        self.lost: FloatArray = np.array([bursts.one_minus_k, bursts.one_minus_h])

    def after(self, messages: int) -> FloatArray:
        """Return how the link is after some messages from mission start, (2,): the probability of good and of bad."""
        state: FloatArray = np.linalg.matrix_power(self.step, messages)[0]
        return state

    def all_lost(self, state: FloatArray, messages: int) -> float:
        """Return the probability that some messages on end are all lost; the link is as `state` (2,) says before."""
        lost: FloatArray = np.linalg.matrix_power(self.lost[:, np.newaxis] * self.step, messages)
        return float((state @ lost).sum())

    def run_lost(self, state: FloatArray, messages: int, run: int) -> float:
        """Return the probability that of some messages at least `run` on end are lost.

        Args:
            state: (2,) how the link is before the first.
            messages: how many there are.
            run: at least 1.
        """
        if messages < run:
            return 0.0
        runs = np.zeros((run, 2))  # by how many were lost last
        runs[0] = state
        exactly = min(messages, _EXACTLY, max(_MOST_SUMS // run, 2 * run))
        spared = before = 1.0
        for _ in range(exactly):
            lost = runs * self.lost
            heard = (runs - lost).sum(axis=0)
            runs[1:] = lost[:-1]
            runs[0] = heard
            runs = runs @ self.step
            before, spared = spared, float(runs.sum())
        later = (spared / before) ** (messages - exactly) if before else 0.0
        return 1.0 - spared * later
