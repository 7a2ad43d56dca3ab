from __future__ import annotations

import math
import random
from itertools import combinations

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.onboard import Point, crossing_sides


def test_a_bow_tie_crosses_itself_and_says_where() -> None:
    assert crossing_sides([(0, 5), (2, 7), (0, 7), (2, 5)]) == (0, 2)
    text = (
        "name: n\npolicy: p\nwaypoints: [[9, 9]]\nonboard: {geofence: {%s: [{corners: [[0,5],[2,7],[0,7],[2,5]]}]}}\n"
    )
    for kind in ("keep_in", "keep_out"):
        with pytest.raises(MissionError) as caught:
            parse_mission((text % kind).encode(), "m.yaml")
        assert (
            f"onboard.geofence.{kind}[0]: crosses itself: its side from corner 1 to corner 2 meets that from "
            in str(caught.value)
        )
    parse_mission((text % "keep_out").replace("[0,7],[2,5]", "[2,5]").encode(), "m.yaml")


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (4, 0), (4, 4), (0, 4)],
        [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0)],  # closed, as GeoJSON has it
        [(0, 0), (6, 0), (6, 6), (0, 6), (0, 3), (2, 3), (2, 4), (4, 4), (4, 2), (2, 2), (2, 3), (0, 3)],  # a slit
        [(0, 0), (2, 2), (4, 0), (4, 4), (2, 2), (0, 4)],  # two corners that touch
    ],
)
def test_sides_that_touch_do_not_cross(corners: list[Point]) -> None:
    assert crossing_sides(corners) is None


def _meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Solve a + t (b - a) = c + u (d - c), another way than the sides' signs."""
    (rx, ry), (sx, sy) = (b[0] - a[0], b[1] - a[1]), (d[0] - c[0], d[1] - c[1])
    across = rx * sy - ry * sx
    if across == 0:
        return False
    t = ((c[0] - a[0]) * sy - (c[1] - a[1]) * sx) / across
    u = ((c[0] - a[0]) * ry - (c[1] - a[1]) * rx) / across
    return 0 < t < 1 and 0 < u < 1


def test_random_polygons_are_told_as_every_pair_of_sides_tells() -> None:
    rng = random.Random(5)
    crossed = 0
    for _ in range(300):
        count = rng.randrange(3, 8)
        corners = [(rng.random(), rng.random()) for _ in range(count)]
        sides = [(corners[at], corners[(at + 1) % count]) for at in range(count)]
        pairs = {(i, j) for (i, one), (j, other) in combinations(enumerate(sides), 2) if _meet(*one, *other)}
        found = crossing_sides(corners)
        assert found in pairs if pairs else found is None
        crossed += bool(pairs)
    assert 50 < crossed < 290


def test_a_thousand_corners_are_looked_at_soon() -> None:
    ring = [(math.cos(at / 1000 * math.tau), math.sin(at / 1000 * math.tau)) for at in range(1000)]
    assert crossing_sides(ring) is None
    ring[10], ring[11] = ring[11], ring[10]
    assert crossing_sides(ring) == (9, 11)
