"""A table as a terminal shows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.table import Table

    from waypointctl.cli.tui.table_layout import Fitted
    from waypointctl.evaluation.grid import Grid

_STRIKING: Final = "yellow"


@dataclass(frozen=True, slots=True)
class GridView:
    """A table to print, its title above it and its notes below.

    Where the terminal is too narrow whole columns are left out, and a line names them.

    Attributes:
        grid: the table.
        options: that show all columns, or files that have them, for that line.
        ruled: rows with a line below them, by index.
        striking: rows that are to be seen first, by index.
    """

    grid: Grid
    options: tuple[str, ...] = ("--json",)
    ruled: tuple[int, ...] = ()
    striking: tuple[int, ...] = ()

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Give rich what there is to print."""
        from rich.text import Text

        from waypointctl.cli.tui.table_layout import fitted

        grid = self.grid.printable()
        fit = fitted(grid, options.max_width)
        if grid.title:
            yield Text(grid.title, style="table.title")
        yield self._table(fit)
        if fit.left_out:
            yield Text(_left_out(fit.left_out, self.options), style="dim")
        yield from (Text(note, style="table.caption") for note in grid.notes)

    def _table(self, fit: Fitted) -> Table:
        from rich import box
        from rich.table import Table

        table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), show_edge=False)
        for column, width in zip(fit.grid.columns, fit.widths, strict=True):
            text = column.is_text
            table.add_column(
                column.heading, justify="left" if text else "right", width=width, no_wrap=not text, overflow="fold"
            )
        for number, row in enumerate(fit.grid.rows):
            style = _STRIKING if number in self.striking else None
            table.add_row(*row, style=style, end_section=number in self.ruled)
        return table


def _left_out(headings: Sequence[str], options: Sequence[str]) -> str:
    named = ", ".join(f"'{heading}'" if "," in heading else heading for heading in headings)
    *others, last = ("a wider terminal", *options)
    shown_by = f"{', '.join(others)} or {last}" if others else last
    return f"left out: {named}; {shown_by} shows {'it' if len(headings) == 1 else 'them'}"
