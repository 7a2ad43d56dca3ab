"""The fence against slower and simpler ways to the same answer."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from waypointctl.flight.executive.rules import Circle, Fence, Point, Polygon

SQUARE = Polygon("square", ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)))
HOLE = Circle("hole", (5.0, 5.0), 1.0)
# A comb: its teeth have corners at the height of others' corners, where a ray meets them.
COMB = Polygon(
    "comb", ((0.0, 0.0), (9.0, 0.0), (9.0, 5.0), (8.0, 1.0), (6.0, 5.0), (4.0, 1.0), (3.0, 5.0), (2.0, 1.0), (0.0, 5.0))
)

coordinates = st.floats(-20.0, 20.0).map(lambda value: round(value, 3))
points = st.tuples(coordinates, coordinates)


def winding_number(corners: tuple[Point, ...], point: Point) -> float:
    """Return how often a closed line goes round a point, by the angles that its edges are seen under."""
    angles = [math.atan2(y - point[1], x - point[0]) for x, y in corners]
    turns = [math.remainder(b - a, math.tau) for a, b in zip(angles, [*angles[1:], angles[0]], strict=True)]
    return sum(turns) / math.tau


def distance_to_border(corners: tuple[Point, ...], point: Point) -> float:
    return min(distance_to_edge(a, b, point) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))


def distance_to_edge(a: Point, b: Point, point: Point) -> float:
    length = math.dist(a, b)
    along = ((point[0] - a[0]) * (b[0] - a[0]) + (point[1] - a[1]) * (b[1] - a[1])) / length**2 if length else 0.0
    along = min(1.0, max(0.0, along))
    return math.dist(point, (a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1])))


@st.composite
def simple_polygons(draw: st.DrawFn) -> Polygon:
    """Corners in the order of their direction from a centre: no edge crosses another."""
    seed, count = draw(st.integers(0, 10**6)), draw(st.integers(3, 12))
    randomly = random.Random(seed)
    x, y = randomly.uniform(-5, 5), randomly.uniform(-5, 5)
    angles = sorted(randomly.uniform(0, math.tau) for _ in range(count))
    radii = [randomly.uniform(0.5, 12) for _ in range(count)]
    corners = [(x + r * math.cos(a), y + r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]
    return Polygon("any", tuple(corners if draw(st.booleans()) else reversed(corners)))


@settings(deadline=None)
@given(polygon=simple_polygons(), point=points)
def test_a_point_is_in_a_polygon_that_winds_round_it(polygon: Polygon, point: Point) -> None:
    assume(distance_to_border(polygon.corners_m, point) > 1e-6)
    assert polygon.holds(point) == (abs(winding_number(polygon.corners_m, point)) > 0.5)


@settings(deadline=None)
@given(x=st.integers(-1, 10), y=st.integers(-1, 6))
def test_corners_at_the_points_own_height_count_once(x: int, y: int) -> None:
    point = (float(x), float(y))
    on_border = distance_to_border(COMB.corners_m, point) < 1e-9
    assert COMB.holds(point) == (on_border or abs(winding_number(COMB.corners_m, point)) > 0.5)


@settings(deadline=None)
@given(polygon=simple_polygons(), at=st.floats(0.0, 1.0), edge=st.integers(0, 11))
def test_a_border_is_a_border_wherever_the_corners_begin(polygon: Polygon, at: float, edge: int) -> None:
    corners = polygon.corners_m
    shift = edge % len(corners)
    turned = Polygon("turned", corners[shift:] + corners[:shift])
    point = (corners[0][0] * at, corners[0][1] * (1 - at))
    assert turned.holds(point) == polygon.holds(point)
    assert all(polygon.holds(corner) for corner in corners)


@pytest.mark.parametrize(("point", "inside"), [((0, 0), True), ((10, 5), True), ((5, 10), True), ((10.001, 5), False)])
def test_the_border_belongs_to_its_area(point: Point, inside: bool) -> None:
    assert SQUARE.holds(point) is inside
    assert HOLE.holds((6.0, 5.0))
    assert not HOLE.holds((6.0001, 5.0))


def test_a_fence_names_what_is_broken() -> None:
    fence = Fence((SQUARE, Circle("annex", (12.0, 5.0), 3.0)), (HOLE,))
    assert fence.breach(1.0, 1.0) == ""
    assert fence.breach(14.0, 5.0) == "", "one of the areas to be in is enough"
    assert fence.breach(5.0, 5.5) == "is inside keep-out hole"
    assert fence.breach(20.0, 5.0) == "is outside keep-in"
    assert Fence().breach(1e9, -1e9) == ""


@pytest.mark.parametrize(
    ("place", "of_any", "of_all"),
    [
        ((9.5, 5.0), "", ""),
        ((1.0, 1.0), "", "is outside keep-in annex"),
        ((14.0, 5.0), "", "is outside keep-in square"),
        ((20.0, 5.0), "is outside keep-in", "is outside keep-in square"),
    ],
)
def test_areas_to_stay_in_hold_one_by_one_or_all_together(place: Point, of_any: str, of_all: str) -> None:
    areas = (SQUARE, Circle("annex", (12.0, 5.0), 3.0))
    assert Fence(areas).breach(*place) == of_any
    assert Fence(areas, keep_in_all=True).breach(*place) == of_all


@settings(deadline=None)
@given(
    start=points,
    end=points,
    polygon=simple_polygons(),
    center=points,
    radius=st.floats(0.1, 10.0),
    keep_in=st.booleans(),
    keep_in_all=st.booleans(),
)
def test_a_way_breaks_the_fence_where_one_of_its_points_does(
    start: Point, end: Point, polygon: Polygon, center: Point, radius: float, keep_in: bool, keep_in_all: bool
) -> None:
    circle = Circle("pond", center, radius)
    fence = Fence((polygon, circle), (), keep_in_all) if keep_in else Fence((), (polygon, circle))
    found = fence.breach_between(start, end)
    steps = [i / 200 for i in range(201)]
    sampled = [fence.breach(start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])) for t in steps]
    if any(sampled):
        assert found
    if not found:
        assert not any(sampled)


@pytest.mark.parametrize(
    ("start", "end", "breach"),
    [
        ((1.0, 1.0), (9.0, 1.0), ""),
        ((1.0, 5.0), (9.0, 5.0), "is inside keep-out hole"),
        ((1.0, 5.0), (20.0, 5.0), "is inside keep-out hole"),
        ((1.0, 1.0), (20.0, 1.0), "is outside keep-in"),
        ((4.99, 3.0), (5.01, 9.0), "is inside keep-out hole"),
        ((5.0, 5.0), (5.0, 5.0), "is inside keep-out hole"),
        ((1.0, 1.0), (1.0, 1.0), ""),
        ((1.0, 5.0), (3.9, 5.0), ""),
    ],
)
def test_the_way_between_two_places_is_held_against_the_fence(start: Point, end: Point, breach: str) -> None:
    assert Fence((SQUARE,), (HOLE,)).breach_between(start, end) == breach


def test_a_gap_thinner_than_any_sampling_is_found() -> None:
    ditch = Polygon("ditch", ((5.0, -9.0), (5.000001, -9.0), (5.000001, 9.0), (5.0, 9.0)))
    assert Fence((), (ditch,)).breach_between((0.0, 0.0), (10.0, 0.0)) == "is inside keep-out ditch"


def test_a_way_meets_a_circle_where_geometry_says() -> None:
    circle = Circle("pit", (3.0, 2.0), 5.0)
    assert list(circle.crossings((-7.0, 2.0), (13.0, 2.0))) == [0.25, 0.75]
    assert list(circle.crossings((-7.0, 5.0), (13.0, 5.0))) == [0.3, 0.7]
    assert list(circle.crossings((-7.0, 7.0), (13.0, 7.0))) == [0.5, 0.5]
    assert list(circle.crossings((-7.0, 7.1), (13.0, 7.1))) == []
    assert list(circle.crossings((3.0, 2.0), (3.0, 2.0))) == []
    assert [circle.holds((8.0, 2.0)), circle.holds((8.0, 2.1))] == [True, False]
    assert list(Circle("round", (0.0, 0.0), 10.0).crossings((-12.0, -16.0), (12.0, 16.0))) == [0.25, 0.75]
    assert list(Circle("round", (0.0, 0.0), 1.0).crossings((0.75, 0.0), (1.25, 0.0))) == [-3.5, 0.5]


def test_a_way_meets_the_borders_of_a_polygon_and_not_their_extensions() -> None:
    assert sorted(SQUARE.crossings((-5.0, 5.0), (15.0, 5.0))) == [0.25, 0.75]
    assert list(SQUARE.crossings((-5.0, 15.0), (15.0, 15.0))) == []
    assert list(SQUARE.crossings((-5.0, -5.0), (15.0, -5.0))) == []


def test_what_lies_beyond_the_end_of_a_way_is_not_on_it() -> None:
    annex = Circle("annex", (12.0, 5.0), 3.0)
    assert Fence((SQUARE, annex)).breach_between((5.0, 5.0), (14.0, 5.0)) == ""
    assert Fence((SQUARE, annex)).breach_between((5.0, 5.0), (16.0, 5.0)) == "is outside keep-in"
