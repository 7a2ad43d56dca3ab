"""All tables of some evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from waypointctl.evaluation.grid import Grid
from waypointctl.evaluation.names import names_of, notes_on_names
from waypointctl.evaluation.paper_tables import paper_tables
from waypointctl.evaluation.published import PAPER_TABLES_NOTE, is_of_the_paper
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.results_grid import results_grid
from waypointctl.evaluation.suite import Suite

MARKDOWN_HEAD: Final = "<!-- waypointctl eval -->\n"


def tables(suite: Suite, evaluations: Sequence[Evaluation], names: Sequence[str] | None = None) -> list[Grid]:
    """Return the paper's tables where several policies walked its suite, else one table of all results.

    Below the last one it is said whose figures the paper's are, and which policies could be taken for one another.

    Args:
        suite: what was walked.
        evaluations: of each policy.
        names: what each policy is called; None: as `names_of` has it.
    """
    names = names_of(evaluations) if names is None else names
    notes = list(notes_on_names(evaluations, names))
    if suite.tables and len(evaluations) > 1:
        grids = paper_tables(suite, evaluations, names)
        notes[:0] = [PAPER_TABLES_NOTE] if is_of_the_paper(evaluations[0]) else []
    else:
        grids = [results_grid(evaluations, names)]
    return [*grids[:-1], replace(grids[-1], notes=(*grids[-1].notes, *notes))]


def to_markdown(grids: Sequence[Grid]) -> str:
    """Return tables as a Markdown file, which begins with MARKDOWN_HEAD."""
    return "\n\n".join([MARKDOWN_HEAD.rstrip(), *(grid.to_markdown() for grid in grids)]) + "\n"
