"""The table of many flights."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from waypointctl.display_text import printable
from waypointctl.units import seconds

if TYPE_CHECKING:
    from rich.table import Table

    from waypointctl.cli.run_many import Outcome


def flights_table(outcomes: Iterable[Outcome]) -> Table:
    """Return what came of each mission file: its flight's outcome, waypoints, time and log."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold", show_edge=False)
    table.add_column("mission", overflow="fold")
    table.add_column("outcome", no_wrap=True)
    table.add_column("reached", justify="right", no_wrap=True)
    table.add_column("time [s]", justify="right", no_wrap=True)
    table.add_column("log", overflow="fold")
    for outcome in outcomes:
        table.add_row(*_row(outcome), style=_style(outcome))
    return table


def _row(outcome: Outcome) -> tuple[str, ...]:
    if outcome.result is None:
        return printable(outcome.path), "broken" if outcome.problem else "not flown", "-", "-", "-"
    result = outcome.result
    reached = f"{result.waypoints_reached}/{result.waypoints_total}"
    flown = f"{seconds(result.sim_time_ns):.2f}"
    return printable(outcome.mission), result.outcome, reached, flown, printable(result.log or "-")


def _style(outcome: Outcome) -> str | None:
    if outcome.result is None:
        return "red"
    return None if outcome.result.outcome == "success" else "yellow"
