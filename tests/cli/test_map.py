"""The map on a terminal: zones, home and the way there, contact, and messages that were not delivered."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.text import Text

from tests.replay.hand_made import NEAR
from waypointctl.cli.tui.canvas import Canvas
from waypointctl.cli.tui.chart import KEEP_IN, KEEP_OUT, UNHEARD, WAY, WAY_HOME, Scene, draw_map
from waypointctl.log.header import ContactWindows, MissionSetting
from waypointctl.mission.onboard import Zone
from waypointctl.replay.legs import ReturnHome, WaypointStatus, WaypointSummary
from waypointctl.replay.track import Track
from waypointctl.units import NS_PER_S

TIME_NS = np.arange(11) * NS_PER_S
WALK = Track(TIME_NS, TIME_NS, np.linspace(0.0, 10.0, 11), np.zeros(11), np.ones(11))
SITE = Zone("site", True, ((-2.0, -4.0), (12.0, -4.0), (12.0, 6.0), (-2.0, 6.0)))
PIT = Zone("pit", False, ((4.0, 2.0), (6.0, 2.0), (6.0, 4.0), (4.0, 4.0)))
HOME = replace(NEAR, name="home", x_m=2.0, y_m=-2.0)


def drawn(scene: Scene, *, ascii_only: bool = False) -> list[Text]:
    return draw_map(scene, 60, 20, ascii_only=ascii_only)


def styles(rows: list[Text]) -> set[str]:
    return {str(span.style) for row in rows for span in row.spans if row.plain[span.start : span.end].strip()}


def text(rows: list[Text]) -> str:
    return "\n".join(row.plain for row in rows)


def test_zones_are_drawn_with_their_names_each_kind_in_its_style() -> None:
    assert not {KEEP_IN, KEEP_OUT} & styles(drawn(Scene(WALK, ())))
    inside = drawn(Scene(WALK, (), setting=MissionSetting(zones=(SITE,))))
    assert KEEP_IN in styles(inside)
    assert KEEP_OUT not in styles(inside)
    both = drawn(Scene(WALK, (), setting=MissionSetting(zones=(SITE, PIT, replace(PIT, name="2")))))
    assert KEEP_OUT in styles(both)
    for name in ("keep-in site", "keep-out pit", "keep-out 2"):
        assert name in text(both)


def test_a_zone_as_large_as_a_county_leaves_the_way_as_large_as_it_is() -> None:
    county = replace(SITE, outline_m=tuple((1000 * x, 1000 * y) for x, y in SITE.outline_m))
    around = drawn(Scene(WALK, (), setting=MissionSetting(zones=(county,))))
    row = next(row.plain for row in around if "●" in row.plain)
    assert row.index("●") - row.index("+") > 20


def test_home_is_marked_and_the_way_there_has_a_style_of_its_own() -> None:
    way = ReturnHome(6 * NS_PER_S, "timeout", None)
    returned = Scene(WALK, (), setting=MissionSetting(home=HOME), returns=(way,))
    assert "⌂ home" in text(drawn(returned))
    assert "⌂" in text(drawn(returned)[:-1])
    assert "H home" in text(drawn(returned, ascii_only=True))
    assert {WAY, WAY_HOME} <= styles(drawn(returned))
    assert "⌂" not in text(drawn(replace(returned, returns=())))
    assert WAY_HOME not in styles(drawn(replace(returned, returns=())))


def test_the_way_where_nothing_could_be_sent_has_a_style_of_its_own() -> None:
    down = ContactWindows(np.array([0]), np.array([5 * NS_PER_S]))
    assert {WAY, UNHEARD} <= styles(drawn(Scene(WALK, (), setting=MissionSetting(down=down))))
    assert UNHEARD not in styles(drawn(Scene(WALK, (), setting=MissionSetting(up=down))))


def test_messages_that_were_not_delivered_are_marked_where_the_robot_was() -> None:
    rows = drawn(Scene(WALK, (), missing_ns=np.array([5, 5, 8]) * NS_PER_S))
    (row,) = [row.plain for row in rows if "+" in row.plain]
    crosses = [at for at, letter in enumerate(row) if letter == "\N{MULTIPLICATION SIGN}"]
    begin, end = row.index("+"), row.index("●")
    assert [round(10 * (at - begin) / (end - begin)) for at in crosses] == [5, 8]
    assert "3 not delivered" in rows[-1].plain
    assert "not delivered" not in text(drawn(Scene(WALK, ())))


def test_thousands_of_lost_messages_leave_the_names_readable() -> None:
    waypoint = WaypointSummary(NEAR, WaypointStatus.OPEN, None, None, None, None)
    lost = np.linspace(0, 10 * NS_PER_S, 5000).astype(np.int64)
    assert "near" in text(drawn(Scene(WALK, (waypoint,), missing_ns=lost)))


@pytest.mark.parametrize("name", ["近いところ" * 10, "a" * 64, "e\N{COMBINING ACUTE ACCENT}" * 40])
def test_a_name_of_any_letters_keeps_the_map_as_wide_as_it_is(name: str) -> None:
    waypoint = WaypointSummary(replace(NEAR, name=name), WaypointStatus.OPEN, None, None, None, None)
    rows = drawn(Scene(WALK, (waypoint,), setting=MissionSetting(zones=(replace(SITE, name=name),))))
    assert {row.cell_len for row in rows[:-1]} == {60}
    assert "..." in text(rows)


def test_a_name_stands_where_it_covers_nothing_if_there_is_such_a_place() -> None:
    waypoint = WaypointSummary(replace(NEAR, x_m=5.0, y_m=0.0), WaypointStatus.OPEN, None, None, None, None)
    rows = drawn(Scene(WALK, (waypoint,)))
    (row,) = [row.plain for row in rows if "near" in row.plain]
    assert "+" not in row, "beside the waypoint it would stand on the way"


coordinate = st.floats(-500, 500) | st.floats(-1e9, 1e9)


@given(st.lists(st.tuples(coordinate, coordinate), min_size=2, max_size=6))
def test_a_line_is_drawn_where_it_crosses_the_canvas_however_long_it_is(points: list[tuple[float, float]]) -> None:
    canvas = Canvas(20, 10)
    x, y = np.array(points).T
    canvas.polyline(x, y, "")
    filled = np.argwhere(canvas._dots.reshape(canvas.height, canvas.width))
    for row, column in filled:  # each dot is on a line
        assert min(_distance((column + 0.5, row + 0.5), a, b) for a, b in pairwise(points)) < 1.5
    for a, b in pairwise(points):  # and each point of a line that is within has its dot
        for share in np.linspace(0, 1, 50):
            at = np.array(a) + share * (np.array(b) - np.array(a))
            if 0 <= at[0] < canvas.width and 0 <= at[1] < canvas.height and max(map(abs, (*a, *b))) < 1e6:
                near = np.abs(filled - np.floor(at[::-1])).max(axis=1)
                assert near.min() <= 1


def _distance(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    p, start, way = np.array(point), np.array(a), np.array(b) - np.array(a)
    length = float(way @ way)
    share = 0.0 if length == 0 else float(np.clip((p - start) @ way / length, 0, 1))
    return float(np.hypot(*(p - start - share * way)))
