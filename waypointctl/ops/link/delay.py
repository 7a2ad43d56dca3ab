"""How long a message is under way: light time, fixed or from a table, and what the network adds to it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

Delay: TypeAlias = Callable[[int], int]  # the moment a message has left [ns] -> one-way delay [ns]
Jitter: TypeAlias = Callable[[], int]  # what is added to one message's delay [ns]; may be negative


def fixed_delay(delay_ns: int) -> Delay:
    """Return a delay that never changes, in [ns]."""
    return lambda _: delay_ns


def table_delay(table: Sequence[tuple[int, int]]) -> Delay:
    """Return a delay that is interpolated between the rows of a table, and constant before and after it.

    Args:
        table: (time, delay), both in [ns], times rising.
    """
    times, delays = [time for time, _ in table], [delay for _, delay in table]

    def at(left_ns: int) -> int:
        after = bisect_right(times, left_ns)
        if after == 0 or after == len(times):
            return delays[min(after, len(times) - 1)]
        begin, span = times[after - 1], times[after] - times[after - 1]
        return delays[after - 1] + (delays[after] - delays[after - 1]) * (left_ns - begin) // span

    return at


def uniform_jitter(spread_ns: int, rng: np.random.Generator) -> Jitter:
    """Return a jitter that lies evenly within +-spread [ns]."""
    return lambda: int(rng.integers(-spread_ns, spread_ns, endpoint=True))


def normal_jitter(deviation_ns: int, rng: np.random.Generator) -> Jitter:
    """Return a jitter with a normal distribution of mean 0 and this standard deviation [ns]."""
    return lambda: round(rng.standard_normal() * deviation_ns)


def drawn_jitter(samples_ns: Sequence[int], rng: np.random.Generator) -> Jitter:
    """Return a jitter that is drawn from measured ones [ns], each as likely."""
    samples, count = tuple(samples_ns), len(samples_ns)
    return lambda: samples[int(rng.random() * count)]
