"""Where the robot was, or was said to be: a row at a time, and as arrays."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A hundred times as far as a mission can ask for. An altered log can say anything, even what no map has room for.
FARTHEST_M: Final = 1e6


def is_on_map(*values: float) -> bool:
    """Return whether places [m] and speeds [m/s] can be drawn and summed: finite, and at most FARTHEST_M."""
    return all(abs(value) <= FARTHEST_M for value in values)  # not so of a NaN


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where the robot was: one row a control step of the truth, or a frame of telemetry, that is on the map."""

    time_ns: IntArray  # (n,) when it was there
    known_ns: IntArray  # (n,) when it was known: the same again for the truth, the arrival for telemetry
    x_m: FloatArray  # (n,)
    y_m: FloatArray  # (n,)
    speed_mps: FloatArray  # (n,) over ground

    def __len__(self) -> int:
        """Return n."""
        return len(self.time_ns)

    def thinned(self, most: int) -> Track:
        """Return every k-th row and the last one, so that there are no more than `most` + 1."""
        stride = max(1, -(-len(self) // most))
        rows = np.arange(0, len(self), stride)
        if len(rows) and rows[-1] != len(self) - 1:
            rows = np.append(rows, len(self) - 1)
        return self.at(rows)

    def newest(self) -> Track:
        """Return the rows that were news when they became known; without frames that newer ones had overtaken."""
        newest_ns = np.maximum.accumulate(self.time_ns)
        is_news = np.ones(len(self), np.bool_)
        is_news[1:] = newest_ns[1:] > newest_ns[:-1]
        return self.at(np.flatnonzero(is_news))

    def between(self, begin_ns: int, end_ns: int) -> Track:
        """Return the rows from `begin_ns` to `end_ns` [ns], both included."""
        return self.at(np.flatnonzero((self.time_ns >= begin_ns) & (self.time_ns <= end_ns)))

    def nearest(self, times_ns: IntArray) -> Track:
        """Return, for each of `times_ns` (m,), the last row not after it; the first where all are."""
        if not len(self):
            return self
        return self.at(np.maximum(np.searchsorted(self.time_ns, times_ns, "right") - 1, 0))

    def last(self) -> Track:
        """Return the last row; none where there is none."""
        return self.at(np.arange(len(self))[-1:])

    def at(self, rows: IntArray) -> Track:
        """Return the rows of these indices (m,)."""
        return Track(self.time_ns[rows], self.known_ns[rows], self.x_m[rows], self.y_m[rows], self.speed_mps[rows])


class GrowingTrack:
    """Collects the rows of a `Track`."""

    def __init__(self) -> None:
        """Begin empty."""
        self._time_ns, self._known_ns = array("q"), array("q")
        self._x_m, self._y_m, self._speed_mps = array("d"), array("d"), array("d")

    def add(self, time_ns: int, known_ns: int, x_m: float, y_m: float, speed_mps: float) -> None:
        """Add a row."""
        self._time_ns.append(time_ns)
        self._known_ns.append(known_ns)
        self._x_m.append(x_m)
        self._y_m.append(y_m)
        self._speed_mps.append(speed_mps)

    def track(self, most: int | None = None) -> Track:
        """Return a copy of all rows, or of about `most` of them, the last one among them."""
        count = len(self._time_ns)
        rows = slice(None, None, 1 if most is None else max(1, count // most))
        last = slice(count if rows.step == 1 else -1, None)

        def times(values: array[int]) -> IntArray:
            return np.array(values[rows] + values[last], np.int64)

        def numbers(values: array[float]) -> FloatArray:
            return np.array(values[rows] + values[last], np.float64)

        places = (numbers(self._x_m), numbers(self._y_m), numbers(self._speed_mps))
        return Track(times(self._time_ns), times(self._known_ns), *places)
