"""Where what is for people goes when there is no terminal."""

from __future__ import annotations

import pytest
from rich.table import Table

from waypointctl.cli.console import console


def wide_table() -> Table:
    table = Table(box=None)
    table.add_column("left")
    table.add_column("right")
    table.add_row("a" * 70, "b" * 70)
    table.add_row("c", "d")
    return table


def test_a_pipe_gets_the_whole_table_and_no_spaces_at_the_end(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    console().print(wide_table())
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines] == [["left", "right"], ["a" * 70, "b" * 70], ["c", "d"]]
    assert [line for line in lines if line != line.rstrip()] == []


def test_columns_that_are_asked_for_are_given(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    people = console(stderr=True)
    assert people.width == 60
    people.print(wide_table())
    captured = capsys.readouterr()
    assert captured.out == ""
    assert max(map(len, captured.err.splitlines())) <= 60
