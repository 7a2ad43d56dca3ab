"""What an evaluation found, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from waypointctl.evaluation.result import CaseResult, Evaluation


def evaluation_table(evaluation: Evaluation) -> Table:
    """Return an evaluation for people: a row for each case, beside the published rate."""
    from rich import box
    from rich.table import Table

    acceptance = evaluation.acceptance
    title = (
        f"{evaluation.policy} in the suite {evaluation.suite}, seed {evaluation.seed}, "
        f"{acceptance.shape} of {acceptance.size_m:g} m"
    )
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", pad_edge=False)
    table.add_column("case", no_wrap=True)
    table.add_column("waypoints [m]")
    for heading in ("success", "rate", "95 % interval", "paper", "falls", "late", "time [s]", "SPL"):
        table.add_column(heading, justify="right", no_wrap=True)
    for case in evaluation.cases:
        table.add_row(*_row(case))
    return table


def _row(case: CaseResult) -> tuple[str, ...]:
    low, high = case.wilson95
    return (
        case.name,
        " ".join(f"({x:g}, {y:g})" for x, y in case.waypoints),
        f"{case.successes}/{case.trials}",
        f"{case.rate:.1%}",
        f"{low:.1%} - {high:.1%}",
        "" if case.paper is None else f"{case.paper:.0%}",
        str(case.falls),
        str(case.timeouts),
        "" if case.mean_time_s is None else f"{case.mean_time_s:.2f}",
        f"{case.spl:.3f}",
    )
