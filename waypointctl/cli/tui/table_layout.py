"""What of a table a terminal has room for: which columns, how wide, and where their text is broken."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from waypointctl.evaluation.grid import Column, Grid

GAP: Final = 2  # columns of the terminal between two of the table

_NARROWEST: Final = 12  # of a text whose words are broken because there is no room otherwise
_LINES: Final = 2  # that a cell is broken into rather than leave a column out
_LONG_WORD: Final = 24  # up to this, or a third of the terminal, a word is never broken
_SPACE: Final = re.compile(r" (?![^(]*\))")  # not one inside a point: "(7, 12)" is one word
_PIECE: Final = re.compile(r"[^-/_.]*[-/_.]+|[^-/_.]+")  # of a long name or path


@dataclass(frozen=True, slots=True)
class Fitted:
    """A table as it fits.

    Attributes:
        grid: with the columns that there is room for, all texts broken into lines.
        widths: of its columns.
        left_out: the headings of the others.
    """

    grid: Grid
    widths: tuple[int, ...]
    left_out: tuple[str, ...]


def fitted(grid: Grid, width: int) -> Fitted:
    """Return what a terminal of `width` columns has room for.

    Text is broken into two lines first, between words; then whole columns are left out, so that no number is ever
    cut and no name broken in the middle. Only where nothing is left to leave out do texts take more lines, and only
    where that is not enough either are their words broken.
    """
    longest = max(_LONG_WORD, width // 3)
    least = {index: _least(column, _cells(grid, index), longest) for index, column in enumerate(grid.columns)}
    for index in sorted(least, key=lambda index: -grid.columns[index].spare):
        if _total(least.values()) <= width or not grid.columns[index].spare:
            break
        del least[index]
    widths = _narrowed(grid, least, longest, width) if _total(least.values()) > width else least
    widths = _widened(grid, widths, width)
    left_out = tuple(column.called for index, column in enumerate(grid.columns) if index not in widths)
    return Fitted(_broken_to(grid, widths), tuple(widths.values()), left_out)


def broken(text: str, width: int) -> list[str]:
    """Return a text as lines no wider than `width`: broken between words, long names after a '-', '/', '_' or '.'.

    Only what has none of these is broken elsewhere.
    """
    lines = _filled(_SPACE.split(text), " ", width)
    return [part for line in lines for part in (_pieces(line, width) if _wide(line) > width else [line])]


def _pieces(word: str, width: int) -> list[str]:
    from rich.cells import chop_cells

    lines = _filled(_PIECE.findall(word), "", width)
    return [part for line in lines for part in (chop_cells(line, width) if _wide(line) > width else [line])]


def _filled(parts: Sequence[str], between: str, width: int) -> list[str]:
    lines = [parts[0]]
    for part in parts[1:]:
        longer = f"{lines[-1]}{between}{part}"
        if _wide(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


def _least(column: Column, cells: Sequence[str], longest: int) -> int:
    """Return the width from which on a column can be read well."""
    if column.is_text:
        return max(_two_lines(text, longest) for text in (column.heading, *cells))
    return max(_two_lines(column.heading, longest), *map(_wide, cells), 1)


def _two_lines(text: str, longest: int) -> int:
    """Return the width at which a text takes two lines, or `longest` if that is more; a shorter word stays whole."""
    least = _widest_word(text, longest)
    if _wide(text) > _LINES * longest:
        return longest
    enough = (width for width in range(least, longest) if len(broken(text, width)) <= _LINES)
    return next(enough, max(least, min(longest, _wide(text))))


def _widest_word(text: str, longest: int) -> int:
    return max(1, min(longest, max(map(_wide, _SPACE.split(text)))))


def _narrowed(grid: Grid, widths: dict[int, int], longest: int, width: int) -> dict[int, int]:
    """Return the widths with texts in as many lines as they have words, where nothing is left to leave out."""
    narrow = dict(widths)
    for index in sorted(widths, reverse=True):
        column = grid.columns[index]
        texts = (column.heading, *_cells(grid, index)) if column.is_text else ()
        least = max((_widest_word(text, longest) for text in texts), default=widths[index])
        narrow[index] = max(least, widths[index] - max(0, _total(narrow.values()) - width))
    for index in sorted(widths, reverse=True):
        if grid.columns[index].is_text:
            too_much = max(0, _total(narrow.values()) - width)
            narrow[index] -= min(too_much, max(0, narrow[index] - _NARROWEST))
    return narrow


def _widened(grid: Grid, widths: dict[int, int], width: int) -> dict[int, int]:
    """Return the widths with what is left of the terminal given to those that need it, from left to right."""
    wide = dict(widths)
    for index in widths:
        whole = max(map(_wide, (grid.columns[index].heading, *_cells(grid, index))))
        wide[index] += max(0, min(whole - wide[index], width - _total(wide.values())))
    return wide


def _broken_to(grid: Grid, widths: dict[int, int]) -> Grid:
    def lines(text: str, index: int) -> str:
        return "\n".join(broken(text, widths[index]))

    columns = tuple(replace(grid.columns[index], heading=lines(grid.columns[index].heading, index)) for index in widths)
    rows = tuple(tuple(lines(row[index], index) for index in widths) for row in grid.rows)
    return replace(grid, columns=columns, rows=rows)


def _cells(grid: Grid, index: int) -> list[str]:
    return [row[index] for row in grid.rows]


def _total(widths: Collection[int]) -> int:
    return sum(widths) + GAP * (len(widths) - 1)


def _wide(text: str) -> int:
    from rich.cells import cell_len

    return cell_len(text)
