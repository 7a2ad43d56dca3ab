"""Whether a polygon crosses itself: then what lies inside it is not what whoever drew it means."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]


def crossing_sides(corners: Sequence[Point]) -> tuple[int, int] | None:
    """Return two sides of a polygon that cross, each by the index of its first corner; None where none do.

    Sides that only touch do not cross: corners given twice, and a hole cut in by a slit, are allowed.

    Args:
        corners: (x, y) in either direction, the last joined to the first.
    """
    sides = [(a, b, at) for at, (a, b) in enumerate(zip(corners, (*corners[1:], corners[0]), strict=True))]
    sides.sort(key=lambda side: min(side[0][0], side[1][0]))
    for place, (a, b, at) in enumerate(sides):
        right, top, bottom = max(a[0], b[0]), max(a[1], b[1]), min(a[1], b[1])
        for c, d, other in sides[place + 1 :]:
            if min(c[0], d[0]) > right:  # this one and all after it lie to the right
                break
            if min(c[1], d[1]) > top or max(c[1], d[1]) < bottom:
                continue
            if _cross(a, b, c, d):
                return min(at, other), max(at, other)
    return None


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Tell whether a to b and c to d have a point in common that ends neither."""
    return _left(a, b, c) * _left(a, b, d) < 0 and _left(c, d, a) * _left(c, d, b) < 0


def _left(a: Point, b: Point, point: Point) -> float:
    """Return a number > 0 where a point lies left of the way from a to b, and < 0 where it lies right."""
    turn = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
    return (turn > 0) - (turn < 0)  # its sign alone: products of tiny numbers would vanish
