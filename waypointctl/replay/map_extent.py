"""What part of the ground a map shows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from waypointctl.mission.zones import Zone
from waypointctl.replay.track import FloatArray

_SMALLEST_M: Final = 2.0  # a map is never of less than this
_BEYOND: Final = 0.5  # how far, as a share of the larger side, a map goes beyond the way for the sake of zones


@dataclass(frozen=True, slots=True)
class Extent:
    """A part of the ground: its borders [m]."""

    left_m: float
    right_m: float
    bottom_m: float
    top_m: float


def extent(x_m: FloatArray, y_m: FloatArray, zones: Iterable[Zone] = ()) -> Extent:
    """Return what holds the points x_m, y_m (n,) [m], and of the zones what is near: a large one is cut off."""
    corners = [corner for zone in zones for corner in zone.outline_m]
    across, up = _span(x_m), _span(y_m)
    beyond = _BEYOND * max(across[1] - across[0], up[1] - up[0])
    across = _stretched(across, [x for x, _ in corners], beyond)
    up = _stretched(up, [y for _, y in corners], beyond)
    return Extent(*across, *up)


def _span(values_m: FloatArray) -> tuple[float, float]:
    """Return the least and the largest of some coordinates, at least _SMALLEST_M apart."""
    least, largest = (float(values_m.min()), float(values_m.max())) if len(values_m) else (0.0, 0.0)
    short = max(0.0, _SMALLEST_M - (largest - least)) / 2
    return least - short, largest + short


def _stretched(span: tuple[float, float], corners_m: list[float], beyond_m: float) -> tuple[float, float]:
    """Return a span with the corners in it, as far as they lie at most `beyond_m` outside of it."""
    least, largest = span
    return max(least - beyond_m, min([least, *corners_m])), min(largest + beyond_m, max([largest, *corners_m]))
