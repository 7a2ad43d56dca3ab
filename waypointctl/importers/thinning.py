"""Fewer places along a recorded line, none further from it than a waypoint is wide."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from waypointctl.importers.local_frame import Point


def thinned(points: Sequence[Point], needed: Sequence[int], tolerance_m: float, most: int) -> list[int] | None:
    """Return which places of a line to keep, by Douglas and Peucker's rule; None if they are too many.

    Args:
        points: x and y [m] along the line.
        needed: indices of those to keep whatever their place; the first and the last of the line are kept anyway.
        tolerance_m: no place that is dropped is further than this from the straight way between those kept around it.
        most: places to keep.

    Returns:
        Indices in order.
    """
    line = np.array(points, dtype=np.float64)  # (n, 2) [m]
    kept = sorted({0, len(line) - 1, *needed})
    spans = list(pairwise(kept))
    while spans and len(kept) <= most:
        begin, end = spans.pop()
        if end - begin < 2:
            continue
        away_m = _away_m(line[begin + 1 : end], line[begin], line[end])
        farthest = int(np.argmax(away_m))
        if away_m[farthest] > tolerance_m:
            middle = begin + 1 + farthest
            kept.append(middle)
            spans += [(begin, middle), (middle, end)]
    return sorted(kept) if len(kept) <= most else None


def _away_m(points: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (n,) [m] of points (n, 2) from the straight way between two places."""
    way = b - a
    length_2 = float(way @ way)
    along = np.clip((points - a) @ way / length_2, 0.0, 1.0) if length_2 > 0 else np.zeros(len(points))
    away = points - a - along[:, None] * way
    return np.hypot(away[:, 0], away[:, 1])
