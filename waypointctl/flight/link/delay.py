"""How long a message is under way: light time, fixed or from a table, and what the network adds to it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from waypointctl.flight.link.draws import Draws

Delay: TypeAlias = Callable[[int], int]  # the moment a message has left [ns] -> one-way delay [ns]

_NEARLY_ALL: Final = 4  # standard deviations; one in thirty thousand messages is later


@dataclass(frozen=True, slots=True)
class Jitter:
    """What the network adds to a message's delay.

    Attributes:
        draws: it, for one message after the other [ns]; may be negative.
        most_ns: what it is not more than; one in thirty thousand times, where nothing bounds it.
    """

    draws: Draws[int]
    most_ns: int


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

    def draw(stream: np.random.Generator, count: int) -> list[int]:
        drawn: list[int] = stream.integers(-spread_ns, spread_ns, size=count, endpoint=True).tolist()
        return drawn

    return Jitter(Draws(rng, draw), spread_ns)


def normal_jitter(deviation_ns: int, rng: np.random.Generator) -> Jitter:
    """Return a jitter with a normal distribution of mean 0 and this standard deviation [ns]."""

    def draw(stream: np.random.Generator, count: int) -> list[int]:
        drawn: list[int] = np.rint(stream.standard_normal(count) * deviation_ns).astype(np.int64).tolist()
        return drawn

    return Jitter(Draws(rng, draw), _NEARLY_ALL * deviation_ns)


def drawn_jitter(samples_ns: Sequence[int], rng: np.random.Generator) -> Jitter:
    """Return a jitter that is drawn from measured ones [ns], each as likely."""
    samples = np.asarray(samples_ns, dtype=np.int64)

    def draw(stream: np.random.Generator, count: int) -> list[int]:
        drawn: list[int] = samples[(stream.random(count) * len(samples)).astype(np.int64)].tolist()
        return drawn

    return Jitter(Draws(rng, draw), int(samples.max()))
