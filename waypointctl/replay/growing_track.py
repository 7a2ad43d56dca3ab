"""A track that grows by a row at a time."""

from __future__ import annotations

from array import array

import numpy as np

from waypointctl.replay.story import FloatArray, Track


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

    def way(self, most: int) -> tuple[FloatArray, FloatArray]:
        """Return x (n,) and y (n,) [m] of about `most` rows, the last one among them."""
        stride = max(1, len(self._x_m) // most)
        x_m, y_m = self._x_m[::stride] + self._x_m[-1:], self._y_m[::stride] + self._y_m[-1:]
        return np.array(x_m, np.float64), np.array(y_m, np.float64)

    def track(self) -> Track:
        """Return a copy of all rows."""
        times = (np.array(self._time_ns, np.int64), np.array(self._known_ns, np.int64))
        return Track(*times, np.array(self._x_m), np.array(self._y_m), np.array(self._speed_mps))
