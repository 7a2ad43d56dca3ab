"""What evaluations found, as tables for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from waypointctl.evaluation.grid import Grid
    from waypointctl.evaluation.result import Evaluation

_WRAPPED_WIDTH: Final = 24  # columns that a longer text is given at least
_GAP: Final = 2  # columns between two


def evaluation_table(evaluation: Evaluation, width: int) -> Table:
    """Return an evaluation for people: a row for each case, and how trials failed below it."""
    return evaluations_table([evaluation], width)


def evaluations_table(evaluations: Sequence[Evaluation], width: int) -> Table:
    """Return evaluations in one suite for people: a row for each policy and case."""
    from waypointctl.evaluation.results_grid import results_grid

    return grid_table(results_grid(evaluations), width)


def grid_table(grid: Grid, width: int) -> Table:
    """Return a table for a terminal of `width` columns.

    Where they are too few, whole columns are left out, so that no number is ever cut.
    """
    from rich import box
    from rich.table import Table

    shown = grid.with_columns(_shown(grid, width))
    table = Table(
        title=shown.title or None,
        caption="\n".join(shown.notes) or None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        pad_edge=False,
        padding=(0, 1, 0, 0),
        show_edge=False,
    )
    for column in shown.columns:
        is_text = column.is_text
        table.add_column(column.heading, justify="left" if is_text else "right", no_wrap=not is_text, overflow="fold")
    for row in shown.rows:
        table.add_row(*row)
    return table


def _shown(grid: Grid, width: int) -> list[int]:
    """Return the columns that there is room for, by index."""
    widths = {index: _width(grid, index) for index in range(len(grid.columns))}
    for index in sorted(widths, key=lambda index: -grid.columns[index].spare):
        if sum(widths.values()) + _GAP * (len(widths) - 1) <= width or not grid.columns[index].spare:
            break
        del widths[index]
    return list(widths)


def _width(grid: Grid, index: int) -> int:
    column = grid.columns[index]
    widest = max((len(row[index]) for row in grid.rows), default=0)
    return max(len(column.heading), min(widest, _WRAPPED_WIDTH) if column.is_text else widest)
