"""What evaluations found, as tables for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from waypointctl.cli.tui.grid_view import GridView
    from waypointctl.evaluation.result import Evaluation


def evaluation_table(evaluation: Evaluation, kept: Path) -> GridView:
    """Return an evaluation for people, `kept` in a file: a row for each case, and how trials failed below it."""
    from waypointctl.cli.tui.grid_view import GridView
    from waypointctl.evaluation.tables import results_grid

    return GridView(results_grid([evaluation]), (str(kept),))
