"""When a link can be used: contact windows, each with the rate and the light time that hold in it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

NS_A_BIT_S: Final = 1_000_000_000  # a message of one bit takes this long [ns] at 1 bit/s


@dataclass(frozen=True, slots=True)
class Window:
    """A contact.

    Attributes:
        begin_ns: the first moment at which something can be sent.
        end_ns: by when its last bit has to have left.
        rate_bps: in [bit/s] where it is not the link's own; 0 is without limit.
        delay_ns: one-way delay where it is not the link's own.
    """

    begin_ns: int
    end_ns: int
    rate_bps: float | None = None
    delay_ns: int | None = None


def airtime_ns(bits: int, rate_bps: float) -> int:
    """Return how long sending takes [ns], rounded up; a rate of 0 is without limit."""
    if not rate_bps:
        return 0
    exact = bits * NS_A_BIT_S / rate_bps
    whole = int(exact)
    return whole if whole == exact else whole + 1


class Contacts:
    """Windows in order, once or again and again."""

    def __init__(self, windows: Sequence[Window], period_ns: int = 0) -> None:
        """Take windows that do not overlap; with a period [ns] all of them come again after it."""
        self.windows = tuple(windows)
        self.period_ns = period_ns
        self._ends = [window.end_ns for window in windows]

    def place(self, earliest_ns: int, bits: int, rate_bps: float) -> tuple[int, int, Window] | None:
        """Return when a message can be sent: its first bit, its last bit [ns], and the window; None for never.

        Args:
            earliest_ns: it cannot be sent before.
            bits: its size; it is sent whole, within one window.
            rate_bps: the link's own rate.
        """
        period = self.period_ns
        round_ns = earliest_ns // period * period if period else 0
        at, rounds = bisect_right(self._ends, earliest_ns - round_ns), 0
        while rounds < 2:  # a window that is too short now is too short in each round
            for window in self.windows[at:]:
                begin = max(earliest_ns, window.begin_ns + round_ns)
                rate = rate_bps if window.rate_bps is None else window.rate_bps
                end = begin + airtime_ns(bits, rate)
                if end <= window.end_ns + round_ns:
                    return begin, end, window
            if not period:
                return None
            at, rounds, round_ns = 0, rounds + 1, round_ns + period
        return None

    def next_open_ns(self, now_ns: int) -> int | None:
        """Return from when on [ns] the link can be used, `now_ns` if it can now; None for never again."""
        placed = self.place(now_ns, 0, 0)
        return None if placed is None else placed[0]
