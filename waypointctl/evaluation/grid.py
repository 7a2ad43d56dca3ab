"""A table as plain text cells, for a terminal or Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import compress

from waypointctl.display_text import printable


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table."""

    heading: str  # what stands above it
    is_text: bool = False  # text, which may be wrapped; a number may not
    spare: int = 0  # which columns to leave out first if the table is too wide, the highest first; 0 stays
    of: str = ""  # whose, where other columns have the same heading

    @property
    def called(self) -> str:
        """The heading, with its owner if the heading does not name it."""
        return f"{self.heading} of {self.of}" if self.of else self.heading


@dataclass(frozen=True, slots=True)
class Grid:
    """A table."""

    title: str  # what it is
    columns: tuple[Column, ...]  # from left to right
    rows: tuple[tuple[str, ...], ...]  # each as many cells as there are columns
    notes: tuple[str, ...] = ()  # lines to stand below it

    def without_empty_columns(self) -> Grid:
        """Return the table without the columns that no row has anything in."""
        full = [any(row[index] for row in self.rows) for index in range(len(self.columns))]
        rows = tuple(tuple(compress(row, full)) for row in self.rows)
        return replace(self, columns=tuple(compress(self.columns, full)), rows=rows)

    def printable(self) -> Grid:
        """Return the table with each of its texts on one line, fit to show."""
        columns = tuple(replace(one, heading=printable(one.heading), of=printable(one.of)) for one in self.columns)
        rows = tuple(tuple(map(printable, row)) for row in self.rows)
        return Grid(printable(self.title), columns, rows, tuple(map(printable, self.notes)))

    def to_markdown(self) -> str:
        """Return the table as Markdown, its title in bold above it and its notes below."""
        shown = self.printable()
        lines = [_row(column.heading for column in shown.columns)]
        lines.append(f"|{'|'.join('---' if column.is_text else '---:' for column in shown.columns)}|")
        lines += [_row(row) for row in shown.rows]
        notes = (f"\n{_escaped(note)}" for note in shown.notes)
        return "\n".join([f"**{_escaped(shown.title)}**", "", *lines, *notes])


def markdown_file(head: str, grids: Sequence[Grid]) -> str:
    """Return tables as a Markdown file, which begins with a line that says what wrote it."""
    return "\n\n".join([head.rstrip(), *(grid.to_markdown() for grid in grids)]) + "\n"


def places(waypoints: Sequence[tuple[float, float]], arrow: str = " ") -> str:
    """Return waypoints as people write them: "(7, 12) (14, 14)"."""
    return arrow.join(f"({x:g}, {y:g})" for x, y in waypoints)


def percent(rate: float | None, digits: int = 0) -> str:
    """Return a rate in per cent, nothing for None."""
    return "" if rate is None else f"{rate:.{digits}%}"


def interval(wilson95: tuple[float, float]) -> str:
    """Return an interval in per cent, without the sign: "96.3-100.0"."""
    return f"{wilson95[0] * 100:.1f}-{wilson95[1] * 100:.1f}"


def _row(cells: Iterable[str]) -> str:
    return f"| {' | '.join(map(_escaped, cells))} |"


def _escaped(text: str) -> str:
    for mark in "\\|*_<`":
        text = text.replace(mark, f"\\{mark}")
    return text
