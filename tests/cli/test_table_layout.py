"""What of a table a terminal has room for."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from waypointctl.cli.tui.table_layout import GAP, Fitted, broken, fitted
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
        ("near [m] (a b) c", 8, ["near [m]", "(a b) c"]),
        ("policies/ant-waypoint", 13, ["policies/ant-", "waypoint"]),
        ("policies/ant-waypoint", 21, ["policies/ant-waypoint"]),
        ("waypoint", 5, ["waypo", "int"]),
        ("近い所 x", 4, ["近い", "所", "x"]),
        ("", 3, [""]),
    ],
)
def test_text_is_broken_between_words_and_names_after_their_parts(text: str, width: int, lines: list[str]) -> None:
    assert broken(text, width) == lines


@given(st.text(alphabet="ab-/_. (),近", max_size=40), st.integers(2, 50))
def test_no_line_is_too_wide_and_nothing_is_lost(text: str, width: int) -> None:
    lines = broken(text, width)
    assert all(cell_len(line) <= width for line in lines)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")


def total(fit: Fitted) -> int:
    return sum(fit.widths) + GAP * (len(fit.widths) - 1)


@pytest.mark.parametrize(
    ("width", "left_out"),
    [
        (90, ()),
        (66, ("layout",)),
        (50, ("layout", "steps")),
        (40, ("layout", "steps", "region, radius 0.2 m")),
    ],
)
def test_columns_are_left_out_in_their_order_and_said(width: int, left_out: tuple[str, ...]) -> None:
    fit = fitted(GRID, width)
    assert fit.left_out == left_out
    assert total(fit) <= width
    assert len(fit.grid.columns) == len(fit.widths) == len(GRID.columns) - len(left_out)
    assert (fit.grid.title, fit.grid.notes) == ("title", ("note",))


@pytest.mark.parametrize("width", range(30, 121, 5))
def test_names_and_numbers_are_whole_at_every_width(width: int) -> None:
    fit = fitted(GRID, width)
    assert [row[0] for row in fit.grid.rows] == list(NAMES)
    assert [row[-1] for row in fit.grid.rows] == ["100.0%", "7.0%"]
    for row in fit.grid.rows:
        for cell, cell_width in zip(row, fit.widths, strict=True):
            assert all(cell_len(line) <= cell_width for line in cell.split("\n"))
            assert cell.count("\n") <= 1


def test_where_there_is_room_nothing_is_broken() -> None:
    fit = fitted(GRID, 200)
    assert (fit.grid, fit.left_out) == (GRID, ())
    assert fit.widths == (21, 10, 10, 20, 6)


def test_more_lines_come_last_and_the_numbers_stay() -> None:
    grid = Grid("", (Column("case", is_text=True), Column("rate")), (("one two three four", "100.0%"),))
    fit = fitted(grid, 14)
    assert fit.grid.rows == (("one\ntwo\nthree\nfour", "100.0%"),)


def test_columns_of_one_heading_are_told_apart() -> None:
    columns = (Column("path", is_text=True), Column("CI", spare=1, of="a"), Column("CI", spare=2, of="b"))
    assert fitted(Grid("", columns, (("x", "1" * 9, "2" * 9),)), 12).left_out == ("CI of a", "CI of b")


def test_a_path_of_a_thousand_waypoints_takes_no_time() -> None:
    long = " ".join(f"({n}, {n})" for n in range(1000))
    grid = Grid("", (Column("waypoints", is_text=True, spare=1), Column("n")), ((long, "1"),) * 200)
    assert fitted(grid, 20).left_out == ("waypoints",)


@pytest.mark.parametrize("width", range(16, 60, 3))
def test_where_even_words_have_no_room_they_are_broken_and_nothing_is_lost(width: int) -> None:
    rows = (("checkpoint_components", "time:1 qpos:15 qfrc_applied:14"), ("sha256", "0123456789abcdef" * 4))
    fit = fitted(Grid("", (Column("metadata", is_text=True), Column("value", is_text=True)), rows), width)
    assert total(fit) <= max(width, 26)
    for given_row, row in zip(rows, fit.grid.rows, strict=True):
        for text, cell, cell_width in zip(given_row, row, fit.widths, strict=True):
            assert "".join(cell.split()) == text.replace(" ", "")
            assert all(cell_len(line) <= cell_width for line in cell.split("\n"))
