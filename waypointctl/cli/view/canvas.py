"""A drawing in characters: eight dots a cell, in braille, or one sign a cell where there is only ASCII."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
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
        """Join the points x (n,), y (n,), in dots, with straight lines."""
        if len(x) < 2:
            return self.dots(x, y, style)
        lengths = np.maximum(np.abs(np.diff(x)), np.abs(np.diff(y)))
        # Enough points that no dot between two of them is missed, each placed along the way there.
        at = np.concatenate([[0.0], np.cumsum(lengths)])
        along = np.linspace(0.0, at[-1], int(min(2 * at[-1], 50_000)) + 2)
        self.dots(np.interp(along, at, x), np.interp(along, at, y), style)
        return None

    def sign(self, x: float, y: float, text: str, style: str) -> None:
        """Write `text` beginning in the cell at the dot (x, y), over whatever is drawn there."""
        line, cell = int(y // CELL_HEIGHT), int(x // CELL_WIDTH)
        for offset, letter in enumerate(text):
            if 0 <= line < self.lines and 0 <= cell + offset < self.columns:
                self._signs[line, cell + offset] = letter
                self._style[line, cell + offset] = self._number(style)

    def is_free(self, x: float, y: float, length: int) -> bool:
        """Return whether a text of `length` fits at the dot (x, y) without covering another."""
        line, cell = int(y // CELL_HEIGHT), int(x // CELL_WIDTH)
        if not (0 <= line < self.lines and cell >= 0 and cell + length <= self.columns):
            return False
        return all((line, cell + offset) not in self._signs for offset in range(length))

    def rows(self, *, ascii_only: bool = False) -> list[Text]:
        """Return the lines of the drawing."""
        from rich.text import Text

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


def _letter(pattern: int, ascii_only: bool) -> str:
    if pattern == 0:
        return " "
    return "." if ascii_only else chr(_BLANK + pattern)
