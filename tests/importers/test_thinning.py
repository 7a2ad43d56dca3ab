from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.importers.reading import imported
from waypointctl.importers.local_frame import thinned

coordinate = st.floats(-50, 50).map(lambda value: round(value, 2))
lines = st.lists(st.tuples(coordinate, coordinate), min_size=2, max_size=40)


def away_m(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return the distance from a straight way, by trying 2,000 places along it."""
    ways = (
        ((a[0] + (b[0] - a[0]) * share), (a[1] + (b[1] - a[1]) * share)) for share in (k / 2000 for k in range(2001))
    )
    return min(math.dist(point, place) for place in ways)


@settings(deadline=None, max_examples=40)
@given(points=lines, tolerance_m=st.sampled_from([0.5, 5.0]), data=st.data())
def test_what_is_dropped_is_near_what_is_kept(
    points: list[tuple[float, float]], tolerance_m: float, data: st.DataObject
) -> None:
    needed = data.draw(st.lists(st.integers(0, len(points) - 1), max_size=3))
    kept = thinned(points, needed, tolerance_m, len(points))
    assert kept is not None
    assert thinned(points, needed, tolerance_m, len(kept)) == kept
    assert thinned(points, needed, tolerance_m, len(kept) - 1) is None
    assert kept == sorted(set(kept))
    assert {0, len(points) - 1, *needed} <= set(kept)
    for begin, end in pairwise(kept):
        for dropped in points[begin + 1 : end]:
            assert away_m(dropped, points[begin], points[end]) <= tolerance_m + 0.1


@pytest.mark.parametrize(
    ("points", "kept"),
    [
        ([(0, 0), (1, 0.4), (2, 0)], [0, 2]),
        ([(0, 0), (1, 0.6), (2, 0)], [0, 1, 2]),
        ([(0, 0), (9, 0), (0, 0)], [0, 1, 2]),  # there and back
        ([(0, 0), (3, 0), (2, 0), (9, 0)], [0, 3]),
        ([(0, 0), (12, 0), (9, 0)], [0, 1, 2]),  # past the end
    ],
)
def test_lines_keep_their_course(points: list[tuple[float, float]], kept: list[int]) -> None:
    assert thinned(points, [], 0.5, 9) == kept


def test_a_long_track_is_thinned_and_says_so(tmp_path: Path) -> None:
    def track(count: int) -> str:
        points = "".join(f'<trkpt lat="{60 + at * 1e-6:.7f}" lon="25"/>' for at in range(count))
        return f'<gpx><trk><trkseg>{points}<trkpt lat="60" lon="25.001"/></trkseg></trk></gpx>'

    found = imported(tmp_path, track(1001), "track.gpx")
    assert found.legs == [(0.0, 111.41), (55.8, 0.0)]
    assert found.left_out == ("999 of 1,002 positions: within 0.5 m of the straight way between the others",)
    found = imported(tmp_path, track(1000), "track.gpx")
    assert (len(found.legs), found.left_out) == (1000, ())
