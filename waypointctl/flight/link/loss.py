"""Which messages the link loses, in the terms of Linux's netem: at random, or in bursts after Gilbert and Elliott."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from waypointctl.flight.link.draws import Draws, chances


class Loss(Protocol):
    """Decides message by message, in the order in which they are handed over."""

    def __call__(self) -> bool:
        """Say whether the next message is lost."""

    @property
    def loses_all(self) -> bool:
        """Whether every later message is lost."""

    def state(self) -> dict[str, Any]:
        """Return what becomes of the next message depends on, as plain data."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on where `state` was taken."""


class RandomLoss:
    """Each message is lost with the same probability, whatever became of the one before."""

    __slots__ = ("_chances", "probability")

    def __init__(self, probability: float, rng: np.random.Generator) -> None:
        """Lose this share of the messages; one number of the stream is for each."""
        self.probability = probability
        self._chances = chances(rng)

    def __call__(self) -> bool:
        """Say whether the next message is lost."""
        return self._chances() < self.probability

    @property
    def loses_all(self) -> bool:
        """Whether every later message is lost."""
        return self.probability >= 1

    def state(self) -> dict[str, Any]:
        """Return what becomes of the next message depends on, as plain data."""
        return self._chances.state()

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on where `state` was taken."""
        self._chances.restore(state)


class GilbertElliott:
    """A link that is good or bad, loses more while it is bad, and may change with each message.

    As in netem (`loss gemodel p r 1-h 1-k`) it begins good, a message fares as the link is when it is handed over, and
    then the link changes. In the long run it is bad for p / (p + r) of the messages, for 1/r of them on end, and loses
    (p (1-h) + r (1-k)) / (p + r).

    Attributes:
        to_bad: p, the probability that the good link is bad for the next message.
        to_good: r, the probability that the bad link is good for the next message.
        lost_in_bad: 1-h, the probability that a message is lost while it is bad.
        lost_in_good: 1-k, the same while it is good.
        bad: how the link is for the next message.
    """

    __slots__ = ("_pairs", "bad", "lost_in_bad", "lost_in_good", "to_bad", "to_good")

    def __init__(
        self, to_bad: float, to_good: float, lost_in_bad: float, lost_in_good: float, rng: np.random.Generator
    ) -> None:
        """Take p, r, 1-h and 1-k; two numbers of the stream are for each message, whatever they come to."""
        self.to_bad, self.to_good = to_bad, to_good
        self.lost_in_bad, self.lost_in_good = lost_in_bad, lost_in_good
        self.bad = False
        self._pairs = Draws(rng, _pairs)

    def __call__(self) -> bool:
        """Say whether the next message is lost."""
        change, fate = self._pairs()
        if self.bad:
            self.bad = change >= self.to_good
            return fate < self.lost_in_bad
        self.bad = change < self.to_bad
        return fate < self.lost_in_good

    @property
    def loses_all(self) -> bool:
        """Whether every later message is lost."""
        stays_bad = self.bad and self.to_good <= 0
        return self.lost_in_bad >= 1 and (stays_bad or self.lost_in_good >= 1)

    def state(self) -> dict[str, Any]:
        """Return what becomes of the next message depends on, as plain data."""
        return {"bad": self.bad, **self._pairs.state()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on where `state` was taken."""
        self.bad = state["bad"]
        self._pairs.restore(state)


def _pairs(rng: np.random.Generator, count: int) -> list[tuple[float, float]]:
    numbers: list[float] = rng.random(2 * count).tolist()
    return list(zip(numbers[::2], numbers[1::2], strict=True))
