"""All tables of some evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from waypointctl.evaluation.grid import Grid
from waypointctl.evaluation.paper_tables import paper_tables
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.results_grid import results_grid
from waypointctl.evaluation.suite import Suite

MARKDOWN_HEAD: Final = "<!-- waypointctl eval -->\n"


def tables(suite: Suite, evaluations: Sequence[Evaluation]) -> list[Grid]:
    """Return the paper's tables where several policies walked its suite, else one table of all results."""
    if suite.tables and len(evaluations) > 1:
        return paper_tables(suite, evaluations)
    return [results_grid(evaluations)]


def to_markdown(grids: Sequence[Grid]) -> str:
    """Return tables as a Markdown file, which begins with MARKDOWN_HEAD."""
    return "\n\n".join([MARKDOWN_HEAD.rstrip(), *(grid.to_markdown() for grid in grids)]) + "\n"
