"""Which messages the link loses, in the terms of Linux's netem: at random, or in bursts after Gilbert and Elliott."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

Loss: TypeAlias = Callable[[], bool]  # whether the next message is lost


@dataclass(slots=True)
class RandomLoss:
    """Each message is lost with the same probability, whatever became of the one before."""

    probability: float
    rng: np.random.Generator

    def __call__(self) -> bool:
        """Say whether the next message is lost."""
        return self.rng.random() < self.probability


@dataclass(slots=True)
class GilbertElliott:
    """A link that is good or bad, and loses more while it is bad; it may change with each message.

    `tc-netem(8)`, loss gemodel p r 1-h 1-k. In the long run it is bad for p / (p + r) of the messages, 1/r of them on
    end.

    Attributes:
        to_bad: p, the probability that the good link is bad for the next message.
        to_good: r, the probability that the bad link is good for the next message.
        lost_in_bad: 1-h, the probability that a message is lost while it is bad.
        lost_in_good: 1-k, the same while it is good.
        rng: where chance comes from; two numbers a message, whatever they come to.
        bad: how the link is now.
    """

    to_bad: float
    to_good: float
    lost_in_bad: float
    lost_in_good: float
    rng: np.random.Generator
    bad: bool = False

    def __call__(self) -> bool:
        """Say whether the next message is lost."""
        random = self.rng.random
        changes, fate = random(), random()
        if self.bad:
            self.bad = changes >= self.to_good
        else:
            self.bad = changes < self.to_bad
        return fate < (self.lost_in_bad if self.bad else self.lost_in_good)
