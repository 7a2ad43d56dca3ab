"""What several seeds came to, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.cli.tui.training_words import count, exact_percent, span

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from waypointctl.cli.tui.grid_view import GridView
    from waypointctl.evaluation.grid import Grid
    from waypointctl.training.seed_result import Spread
    from waypointctl.training.seeds import SeedsResult

# By quantity: the heading, how a number is written, and what is left out first on a narrow terminal.
_COLUMNS: Final[dict[str, tuple[str, Callable[[float], str], int]]] = {
    "success_rate": ("success", exact_percent, 0),
    "fall_rate": ("falls", exact_percent, 1),
    "timeout_rate": ("time-outs", exact_percent, 2),
    "spl": ("SPL", "{:.3f}".format, 3),
    "selection_rate": ("selection", exact_percent, 6),
    "steps": ("steps", count, 4),
    "wall_time_s": ("time", span, 5),
}


def seeds_table(name: str, compared: SeedsResult, kept: Path) -> GridView:
    """Return a row for each seed, and mean, standard deviation, lowest and highest over them; `kept` has all."""
    from waypointctl.cli.tui.grid_view import GridView

    return GridView(_grid(name, compared), (str(kept),), ruled=(len(compared.results) - 1,))


def _grid(name: str, compared: SeedsResult) -> Grid:
    from waypointctl.evaluation.grid import Column, Grid

    columns = {quantity: column for quantity, column in _COLUMNS.items() if quantity in compared.spread}
    rows = [
        (str(result.seed), *(text(getattr(result, quantity)) for quantity, (_, text, _) in columns.items()))
        for result in compared.results
    ]
    for part in ("mean", "std", "lowest", "highest"):
        cells = (_cell(compared.spread[quantity], part, text) for quantity, (_, text, _) in columns.items())
        rows.append((part, *cells))
    headings = (Column("seed", is_text=True), *(Column(heading, spare=spare) for heading, _, spare in columns.values()))
    return Grid(f"{name} on the paper's paths, by seed of the training", headings, tuple(rows))


def _cell(spread: Spread, part: str, text: Callable[[float], str]) -> str:
    value: float | None = getattr(spread, part)
    return "-" if value is None else text(value)
