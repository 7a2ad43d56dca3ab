"""What of a table a terminal has room for."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len
from rich.console import Console

from waypointctl.cli.tui.tables import GAP, GridView, broken, fitted_widths
from waypointctl.evaluation.grid import Column, Grid

NAMES = ("policies/ant-waypoint", "policies/policy1")
GRID = Grid(
    "title",
    (
        Column("folder", is_text=True),
        Column("layout", is_text=True, spare=3),
        Column("steps", spare=2),
        Column("region, radius 0.2 m", is_text=True, spare=1),
        Column("rate"),
    ),
    (
        (NAMES[0], "egocentric", "16,011,264", "0-100% in 10 cases", "100.0%"),
        (NAMES[1], "state", "10,002,432", "53-100% in 10 cases", "7.0%"),
    ),
    ("note",),
)


@pytest.mark.parametrize(
    ("text", "width", "lines"),
    [
        ("0-100% in 10 cases", 11, ["0-100% in", "10 cases"]),
        ("(7, 12) (14, 14)", 8, ["(7, 12)", "(14, 14)"]),
        ("policies/ant-waypoint", 13, ["policies/ant-", "waypoint"]),
        ("policies/ant-waypoint", 21, ["policies/ant-waypoint"]),
        ("waypoint", 5, ["waypo", "int"]),
        ("", 3, []),
    ],
)
def test_text_is_broken_between_words_and_names_after_their_parts(text: str, width: int, lines: list[str]) -> None:
    assert broken(text, width) == lines


@given(st.text(alphabet="ab-/_. (),", max_size=40), st.integers(2, 50))
def test_no_line_is_too_wide_and_nothing_is_lost(text: str, width: int) -> None:
    lines = broken(text, width)
    assert all(cell_len(line) <= width for line in lines)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")


def total(widths: dict[int, int]) -> int:
    return sum(widths.values()) + GAP * (len(widths) - 1)


@pytest.mark.parametrize(("width", "kept"), [(90, "01234"), (66, "0234"), (50, "034"), (40, "04")])
def test_columns_are_left_out_in_their_order(width: int, kept: str) -> None:
    widths = fitted_widths(GRID, width)
    assert list(widths) == list(map(int, kept))
    assert total(widths) <= width


@pytest.mark.parametrize("width", range(30, 121, 5))
def test_names_and_numbers_are_whole_at_every_width(width: int) -> None:
    widths = fitted_widths(GRID, width)
    assert widths[0] >= cell_len(NAMES[0])
    for row in GRID.rows:
        assert len(broken(row[-1], widths[4])) == 1
        assert all(len(broken(row[index], cell_width)) <= 2 for index, cell_width in widths.items())


def test_where_there_is_room_nothing_is_broken() -> None:
    assert fitted_widths(GRID, 200) == {0: 21, 1: 10, 2: 10, 3: 20, 4: 6}


def test_more_lines_come_last_and_the_numbers_stay() -> None:
    grid = Grid("", (Column("case", is_text=True), Column("rate")), (("one two three four", "100.0%"),))
    widths = fitted_widths(grid, 14)
    assert widths[1] == 6
    assert broken("one two three four", widths[0]) == ["one", "two", "three", "four"]


def test_columns_of_one_heading_are_told_apart() -> None:
    columns = (Column("path", is_text=True), Column("CI", spare=1, of="a"), Column("CI", spare=2, of="b"))
    console = Console(width=12, file=io.StringIO())
    with console.capture() as capture:
        console.print(GridView(Grid("", columns, (("x", "1" * 9, "2" * 9),))))
    assert "CI of a, CI of b" in " ".join(capture.get().split())


def test_a_path_of_a_thousand_waypoints_takes_no_time() -> None:
    long = " ".join(f"({n}, {n})" for n in range(1000))
    grid = Grid("", (Column("waypoints", is_text=True, spare=1), Column("n")), ((long, "1"),) * 200)
    assert list(fitted_widths(grid, 20)) == [1]


@pytest.mark.parametrize("width", range(16, 60, 3))
def test_where_even_words_have_no_room_they_are_broken_and_nothing_is_lost(width: int) -> None:
    rows = (("checkpoint_components", "time:1 qpos:15 qfrc_applied:14"), ("sha256", "0123456789abcdef" * 4))
    widths = fitted_widths(Grid("", (Column("metadata", is_text=True), Column("value", is_text=True)), rows), width)
    assert total(widths) <= width
    for row in rows:
        for index, cell_width in widths.items():
            lines = broken(row[index], cell_width)
            assert "".join(lines).replace(" ", "") == row[index].replace(" ", "")
            assert all(cell_len(line) <= cell_width for line in lines)
