"""What an evaluation found, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rich.table import Table

    from waypointctl.evaluation.result import CaseResult, Evaluation

_TEXTS: Final = ("case", "waypoints [m]")  # may be wrapped; numbers may not
_LEFT_OUT_FIRST: Final = ("waypoints [m]", "late", "time [s]", "SPL", "falls", "paper", "95 % CI [%]")
_WRAPPED_WIDTH: Final = 24  # columns that a longer text is given at least
_GAP: Final = 2  # columns between two


def evaluation_table(evaluation: Evaluation, width: int) -> Table:
    """Return an evaluation for people: a row for each case, beside the published rate.

    Where `width` columns are too few, whole columns are left out, so that no number is ever cut.
    """
    from rich import box
    from rich.table import Table

    acceptance = evaluation.acceptance
    title = (
        f"{evaluation.policy} in the suite {evaluation.suite}, seed {evaluation.seed}, "
        f"{acceptance.shape} of {acceptance.size_m:g} m"
    )
    table = Table(
        title=title, box=box.SIMPLE_HEAD, title_justify="left", pad_edge=False, padding=(0, 1, 0, 0), show_edge=False
    )
    rows = [_cells(case) for case in evaluation.cases]
    shown = _shown(rows, width)
    for heading in shown:
        is_text = heading in _TEXTS
        table.add_column(heading, justify="left" if is_text else "right", no_wrap=not is_text, overflow="fold")
    for row in rows:
        table.add_row(*(row[heading] for heading in shown))
    return table


def _shown(rows: list[dict[str, str]], width: int) -> list[str]:
    """Return the headings of the columns that there is room for."""
    widths = {heading: max(len(heading), *(len(row[heading]) for row in rows)) for heading in rows[0]} if rows else {}
    for heading in widths.keys() & set(_TEXTS):
        widths[heading] = min(widths[heading], _WRAPPED_WIDTH)
    for heading in _LEFT_OUT_FIRST:
        if sum(widths.values()) + _GAP * (len(widths) - 1) <= width:
            break
        widths.pop(heading, None)
    return list(widths)


def _cells(case: CaseResult) -> dict[str, str]:
    low, high = case.wilson95
    return {
        "case": case.name,
        "waypoints [m]": " ".join(f"({x:g}, {y:g})" for x, y in case.waypoints),
        "success": f"{case.successes}/{case.trials}",
        "rate": f"{case.rate:.1%}",
        "95 % CI [%]": f"{low * 100:.1f}-{high * 100:.1f}",
        "paper": "" if case.paper is None else f"{case.paper:.0%}",
        "falls": str(case.falls),
        "late": str(case.timeouts),
        "time [s]": "" if case.mean_time_s is None else f"{case.mean_time_s:.2f}",
        "SPL": f"{case.spl:.3f}",
    }
