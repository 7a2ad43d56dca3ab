"""When, and how fast, something can be sent: contact windows, each with its rate."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Final

from waypointctl.units import NS_PER_S

BITS_PER_BYTE: Final = 8
FOREVER_NS: Final = 1 << 62  # beyond every time of a flight, and within what a log can hold


@dataclass(frozen=True, slots=True)
class Window:
    """A contact."""

    begin_ns: int  # the first moment at which something can be sent
    end_ns: int  # by when its last bit has to have left
    rate_bps: float | None = None  # in [bit/s]; None is without limit

    def __post_init__(self) -> None:
        """Refuse a window that nothing can be sent in."""
        if not 0 <= self.begin_ns < self.end_ns:
            raise ValueError(f"a window from {self.begin_ns} to {self.end_ns} ns is none")
        if self.rate_bps is not None and self.rate_bps <= 0:
            raise ValueError(f"a rate of {self.rate_bps} bit/s is none")


def airtime_ns(size_bytes: int, rate_bps: float | None) -> int:
    """Return how long sending takes [ns], rounded up: no rate is ever exceeded, not by the rounding of a float."""
    ns_per_byte, per = _ns_per_byte(rate_bps)
    return -(-size_bytes * ns_per_byte // per)


class Contacts:
    """Windows in order, once or again and again. A message is sent whole, within one window."""

    __slots__ = ("_begin_ns", "_end_ns", "_ends", "_ns_per_byte", "_per", "_rates", "period_ns", "windows")

    def __init__(self, windows: Sequence[Window], period_ns: int = 0) -> None:
        """Take windows in order that do not overlap; with a period [ns] all of them come again after it.

        Raises:
            ValueError: they overlap, are not in order, or the last one ends after the period.
        """
        ends = [window.end_ns for window in windows]
        if any(window.begin_ns < end for window, end in zip(windows[1:], ends, strict=False)):
            raise ValueError("contact windows overlap or are not in order")
        if period_ns and ends and ends[-1] > period_ns:
            raise ValueError(f"a window ends at {ends[-1]} ns, after the period of {period_ns} ns")
        self.windows = tuple(windows)
        self.period_ns = period_ns
        self._ends = ends
        # A byte takes a fraction of nanoseconds: (numerator, denominator), of whole numbers.
        self._rates = [_ns_per_byte(window.rate_bps) for window in windows]
        # The window that was used last, where the next message most likely goes too.
        self._begin_ns, self._end_ns = 0, 0
        self._ns_per_byte, self._per = 0, 1

    def place(self, earliest_ns: int, size_bytes: int) -> tuple[int, int] | None:
        """Return when a message can be sent: its first and its last bit [ns]; None for never.

        Args:
            earliest_ns: it cannot be sent before.
            size_bytes: its size.
        """
        if self._begin_ns <= earliest_ns < self._end_ns:
            left_ns = earliest_ns - (-size_bytes * self._ns_per_byte // self._per)
            if left_ns <= self._end_ns:
                return earliest_ns, left_ns
        return self._search(earliest_ns, size_bytes)

    def next_open_ns(self, now_ns: int) -> int | None:
        """Return from when on [ns] the link can be used, `now_ns` if it can now; None for never again."""
        placed = self.place(now_ns, 0)
        return None if placed is None else placed[0]

    @property
    def has_rates(self) -> bool:
        """Whether sending takes time: whether a window has a rate."""
        return any(window.rate_bps is not None for window in self.windows)

    @property
    def longest_gap_ns(self) -> int:
        """The longest time between two contacts [ns]; what follows the last of them is none."""
        gaps = [after.begin_ns - before.end_ns for before, after in pairwise(self.windows)]
        if self.windows and self.period_ns:
            gaps.append(self.period_ns - self.windows[-1].end_ns + self.windows[0].begin_ns)
        return max(gaps, default=0)

    @property
    def mean_rate_bps(self) -> float | None:
        """What can be sent in the long run [bit/s], None for any amount.

        Contacts that come again count with their share of the time; of others the fastest counts, while it lasts.
        """
        rates = [window.rate_bps for window in self.windows if window.rate_bps is not None]
        if not rates or len(rates) < len(self.windows):
            return None
        if not self.period_ns:
            return max(rates)
        sent = (rate * (each.end_ns - each.begin_ns) for rate, each in zip(rates, self.windows, strict=True))
        return sum(sent) / self.period_ns

    def _search(self, earliest_ns: int, size_bytes: int) -> tuple[int, int] | None:
        period = self.period_ns
        round_ns = earliest_ns // period * period if period else 0
        first = bisect_right(self._ends, earliest_ns - round_ns)
        # What does not fit in what is left of this round, nor in the whole of the next, fits in none.
        for _ in range(2):
            for at in range(first, len(self.windows)):
                window, (ns_per_byte, per) = self.windows[at], self._rates[at]
                begin_ns, end_ns = window.begin_ns + round_ns, window.end_ns + round_ns
                departs_ns = max(earliest_ns, begin_ns)
                left_ns = departs_ns - (-size_bytes * ns_per_byte // per)
                if left_ns <= end_ns:
                    self._begin_ns, self._end_ns, self._ns_per_byte, self._per = begin_ns, end_ns, ns_per_byte, per
                    return departs_ns, left_ns
            if not period:
                return None
            first, round_ns = 0, round_ns + period
        return None


def always(rate_bps: float | None = None) -> Contacts:
    """Return one contact that never ends."""
    return Contacts([Window(0, FOREVER_NS, rate_bps)])


def _ns_per_byte(rate_bps: float | None) -> tuple[int, int]:
    if rate_bps is None:
        return 0, 1
    exact = Fraction(BITS_PER_BYTE * NS_PER_S) / Fraction(rate_bps)
    return exact.numerator, exact.denominator
