"""What the link does to a message, in the terms of Linux's netem: delay, jitter and loss, from named random streams."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, Protocol, TypeAlias, TypeVar

import numpy as np

T = TypeVar("T")

BLOCK: Final = 256

Delay: TypeAlias = Callable[[int], int]  # the moment a message has left [ns] -> one-way delay [ns]
_NEARLY_ALL: Final = 4  # standard deviations; one in thirty thousand messages is later


class Draws(Generic[T]):
    """What one stream gives, one by one.

    numpy gives the same numbers whether they are drawn singly or many at once (a test holds it to that), so
    nothing but the time depends on the block.
    """

    __slots__ = ("_ahead", "_begin", "_draw", "_rng")

    def __init__(self, rng: np.random.Generator, draw: Callable[[np.random.Generator, int], list[T]]) -> None:
        """Take a stream, and a function that draws a given number of values from it."""
        self._rng = rng
        self._draw = draw
        self._begin: Mapping[str, Any] = rng.bit_generator.state  # of the stream, before the block
        self._ahead: list[T] = []  # of the block, the next one last

    def __call__(self) -> T:
        """Return the next one."""
        if not self._ahead:
            self._fill()
        return self._ahead.pop()

    def state(self) -> dict[str, Any]:
        """Return what the next ones depend on, as plain data."""
        used = BLOCK - len(self._ahead) if self._ahead else 0
        return {"stream": dict(self._begin if used else self._rng.bit_generator.state), "used": used}

    def _fill(self) -> None:
        self._begin = self._rng.bit_generator.state
        self._ahead = self._draw(self._rng, BLOCK)
        self._ahead.reverse()


def chances(rng: np.random.Generator) -> Draws[float]:
    """Return numbers that lie evenly in [0, 1)."""
    return Draws(rng, lambda stream, count: stream.random(count).tolist())


@dataclass(frozen=True, slots=True)
class Jitter:
    """What the network adds to a message's delay."""

    draws: Draws[int]  # it, for one message after the other [ns]; may be negative
    most_ns: int  # what it is not more than; one in thirty thousand times, where nothing bounds it


def fixed_delay(delay_ns: int) -> Delay:
    """Return a delay that never changes, in [ns]."""
    return lambda _: delay_ns


def table_delay(table: Sequence[tuple[int, int]]) -> Delay:
    """Return a delay that is interpolated between the rows of a table, and constant before and after it.

    Args:
        table: (time, delay), both in [ns], at least one row, times rising.
    """
    times, delays = [time for time, _ in table], [delay for _, delay in table]

    def at(left_ns: int) -> int:
        after = bisect_right(times, left_ns)
        if after == 0 or after == len(times):
            return delays[after and -1]
        begin, span = times[after - 1], times[after] - times[after - 1]
        return delays[after - 1] + (delays[after] - delays[after - 1]) * (left_ns - begin) // span

    return at


def stepped_delay(table: Sequence[tuple[int, int]]) -> Delay:
    """Return a delay that changes at the rows of a table, (time, delay) in [ns], at least one row, times rising."""
    times, delays = [time for time, _ in table], [delay for _, delay in table]
    return lambda left_ns: delays[max(bisect_right(times, left_ns) - 1, 0)]


def uniform_jitter(spread_ns: int, rng: np.random.Generator) -> Jitter:
    """Return a jitter that lies evenly within +-spread [ns]."""
    draws = Draws[int](rng, lambda rng, count: rng.integers(-spread_ns, spread_ns, count, endpoint=True).tolist())
    return Jitter(draws, spread_ns)


def normal_jitter(deviation_ns: int, rng: np.random.Generator) -> Jitter:
    """Return a jitter with a normal distribution of mean 0 and this standard deviation [ns]."""

    def draw(stream: np.random.Generator, count: int) -> Any:
        return np.rint(stream.standard_normal(count) * deviation_ns).astype(np.int64).tolist()

    return Jitter(Draws[int](rng, draw), _NEARLY_ALL * deviation_ns)


def drawn_jitter(samples_ns: Sequence[int], rng: np.random.Generator) -> Jitter:
    """Return a jitter that is drawn from measured ones [ns], each as likely."""
    samples = np.asarray(samples_ns, dtype=np.int64)

    def draw(stream: np.random.Generator, count: int) -> Any:
        return samples[(stream.random(count) * len(samples)).astype(np.int64)].tolist()

    return Jitter(Draws[int](rng, draw), int(samples.max()))


class Loss(Protocol):
    """Decides message by message, in the order in which they are handed over."""

    def __call__(self) -> bool:
        """Say whether the next message is lost."""

    @property
    def loses_all(self) -> bool:
        """Whether every later message is lost."""

    def state(self) -> dict[str, Any]:
        """Return what becomes of the next message depends on, as plain data."""


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


def _pairs(rng: np.random.Generator, count: int) -> list[tuple[float, float]]:
    numbers: list[float] = rng.random(2 * count).tolist()
    return list(zip(numbers[::2], numbers[1::2], strict=True))
