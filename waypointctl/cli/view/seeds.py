"""What several seeds came to, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from waypointctl.cli.view.training_words import count, exact_percent, span

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.table import Table

    from waypointctl.training.seed_result import Spread
    from waypointctl.training.seeds import SeedsResult

_COLUMNS: dict[str, tuple[str, Callable[[float], str]]] = {
    "success_rate": ("success", exact_percent),
    "fall_rate": ("falls", exact_percent),
    "timeout_rate": ("time-outs", exact_percent),
    "spl": ("SPL", "{:.3f}".format),
    "selection_rate": ("selection", exact_percent),
    "steps": ("steps", count),
    "wall_time_s": ("time", span),
}


def seeds_table(name: str, compared: SeedsResult) -> Table:
    """Return a row for each seed, and mean, standard deviation, lowest and highest over them; 75 columns wide."""
    from rich import box
    from rich.table import Table

    title = f"{name} on the paper's paths, by seed of the training"
    columns = {quantity: column for quantity, column in _COLUMNS.items() if quantity in compared.spread}
    table = Table(
        title=title, box=box.SIMPLE_HEAD, title_justify="left", pad_edge=False, padding=(0, 1, 0, 0), show_edge=False
    )
    table.add_column("seed", no_wrap=True)
    for heading, _ in columns.values():
        table.add_column(heading, justify="right", no_wrap=True)
    last = len(compared.results) - 1
    for number, result in enumerate(compared.results):
        cells = [text(getattr(result, quantity)) for quantity, (_, text) in columns.items()]
        table.add_row(str(result.seed), *cells, end_section=number == last)
    for part in ("mean", "std", "lowest", "highest"):
        table.add_row(part, *(_cell(compared.spread[quantity], part, text) for quantity, (_, text) in columns.items()))
    return table


def _cell(spread: Spread, part: str, text: Callable[[float], str]) -> str:
    value: float | None = getattr(spread, part)
    return "-" if value is None else text(value)
