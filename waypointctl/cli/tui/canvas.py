"""A drawing in characters: eight dots a cell, in braille, or one sign a cell where there is only ASCII."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from rich.cells import cell_len
from rich.text import Text

FloatArray = NDArray[np.float64]

CELL_WIDTH: Final = 2  # dots
CELL_HEIGHT: Final = 4
# The bit of each dot in a braille cell, by row and column (Unicode 1FFF, block U+2800).
_BITS: Final = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]], np.uint8)
_BLANK: Final = 0x2800


class Canvas:
    """Cells of dots, each cell in one style: the last that was drawn into it."""

    def __init__(self, columns: int, lines: int) -> None:
        """Make an empty canvas of `columns` by `lines` characters."""
        self.columns, self.lines = columns, lines
        self.width, self.height = columns * CELL_WIDTH, lines * CELL_HEIGHT  # in dots
        self._dots = np.zeros((lines, CELL_HEIGHT, columns, CELL_WIDTH), np.bool_)
        self._style = np.zeros((lines, columns), np.int16)
        self._styles = [""]
        self._signs: dict[tuple[int, int], str] = {}

    def dots(self, x: FloatArray, y: FloatArray, style: str) -> None:
        """Set the dots at x (n,), from the left, and y (n,), from the top; those outside are left out."""
        column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        inside = (column >= 0) & (column < self.width) & (row >= 0) & (row < self.height)
        column, row = column[inside], row[inside]
        line, cell = row // CELL_HEIGHT, column // CELL_WIDTH
        self._dots[line, row % CELL_HEIGHT, cell, column % CELL_WIDTH] = True
        self._style[line, cell] = self._number(style)

    def polyline(self, x: FloatArray, y: FloatArray, style: str) -> None:
        """Join the points x (n,), y (n,), in dots, with straight lines; what lies outside is left out."""
        if len(x) < 2:
            return self.dots(x, y, style)
        start, way = np.stack([x[:-1], y[:-1]]), np.stack([np.diff(x), np.diff(y)])
        first, last = _inside(start, way, np.array([[self.width], [self.height]]))
        # Enough points that no dot of a line is missed, and none of what lies outside.
        points = np.where(last >= first, np.ceil(2 * np.abs(way).max(axis=0) * (last - first)) + 2, 0).astype(np.int64)
        line = np.repeat(np.arange(len(points)), points)
        number = np.arange(len(line)) - np.repeat(np.cumsum(points) - points, points)
        along = first[line] + (last - first)[line] * number / np.maximum(points[line] - 1, 1)
        x, y = start[:, line] + along * way[:, line]
        return self.dots(x, y, style)

    def sign(self, x: float, y: float, text: str, style: str) -> None:
        """Write `text` beginning in the cell at the dot (x, y), over whatever is drawn there."""
        line, cell = int(y // CELL_HEIGHT), int(x // CELL_WIDTH)
        for offset, letter in enumerate(_cells(text)):
            if 0 <= line < self.lines and 0 <= cell + offset < self.columns:
                self._signs[line, cell + offset] = letter
                self._style[line, cell + offset] = self._number(style)

    def is_free(self, x: float, y: float, text: str) -> bool:
        """Return whether a text fits at the dot (x, y) without covering another."""
        line, cell, length = int(y // CELL_HEIGHT), int(x // CELL_WIDTH), len(_cells(text))
        if not (0 <= line < self.lines and cell >= 0 and cell + length <= self.columns):
            return False
        return all((line, cell + offset) not in self._signs for offset in range(length))

    def covered(self, x: float, y: float, text: str) -> int:
        """Return how many dots a text at the dot (x, y), where it fits, covers."""
        line, cell = int(y // CELL_HEIGHT), int(x // CELL_WIDTH)
        return int(self._dots[line, :, cell : cell + len(_cells(text))].sum())

    def rows(self, *, ascii_only: bool = False) -> list[Text]:
        """Return the lines of the drawing."""
        letters = self._letters(ascii_only)
        rows = []
        for line in range(self.lines):
            row = Text(no_wrap=True)
            for cell in range(self.columns):
                row.append(letters[line][cell], self._styles[self._style[line, cell]])
            rows.append(row)
        return rows

    def _letters(self, ascii_only: bool) -> list[list[str]]:
        patterns = (self._dots * _BITS[np.newaxis, :, np.newaxis, :]).sum(axis=(1, 3), dtype=np.int64)
        # A blank braille cell has a width of its own in some fonts: an empty cell is a space.
        drawn = [[_letter(int(pattern), ascii_only) for pattern in line] for line in patterns]
        for (line, cell), letter in self._signs.items():
            drawn[line][cell] = letter
        return drawn

    def _number(self, style: str) -> int:
        if style not in self._styles:
            self._styles.append(style)
        return self._styles.index(style)


def _cells(text: str) -> list[str]:
    """Return what stands in each cell of a text: a wide letter takes two, and an accent none of its own."""
    cells: list[str] = []
    for letter in text:
        width = cell_len(letter)
        if width == 0 and cells:
            cells[-1] += letter
        else:
            cells += (letter, *[""] * (width - 1))
    return cells


def _inside(start: FloatArray, way: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where lines from `start` (2, n) along `way` (2, n) enter and leave a canvas, as shares of each (n,).

    A line that stays outside leaves before it enters.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        borders = np.stack([-start, size - start]) / way  # (2, 2, n): low and high borders of both axes
    # A line along an axis never meets the borders across: it is within them all the way, or nowhere.
    within = (start >= 0) & (start <= size)
    still = way == 0
    enters = np.where(still, np.where(within, 0.0, np.inf), borders.min(axis=0))
    leaves = np.where(still, np.where(within, 1.0, -np.inf), borders.max(axis=0))
    return np.clip(enters.max(axis=0), 0.0, 2.0), np.clip(leaves.min(axis=0), -1.0, 1.0)


def _letter(pattern: int, ascii_only: bool) -> str:
    if pattern == 0:
        return " "
    return "." if ascii_only else chr(_BLANK + pattern)
