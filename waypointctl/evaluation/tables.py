"""Evaluations as tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from waypointctl.evaluation.grid import Column, Grid, interval, percent, places
from waypointctl.evaluation.paper_tables import PAPER_TABLES_NOTE, is_of_the_paper, paper_tables, published_note
from waypointctl.evaluation.result import CaseResult, Evaluation, names_of, notes_on_names
from waypointctl.evaluation.suite import Suite

MARKDOWN_HEAD: Final = "<!-- waypointctl eval -->\n"
_COLUMNS: Final = (
    Column("policy", is_text=True),
    Column("case", is_text=True),
    Column("waypoints [m]", is_text=True, spare=10),
    Column("success"),
    Column("rate"),
    Column("95 % CI [%]", spare=1),
    Column("paper", spare=2),
    Column("falls", spare=3),
    Column("time-outs", spare=4),
    Column("strayed", spare=5),
    Column("legs", spare=6),
    Column("time [s]", spare=8),
    Column("SPL", spare=7),
    Column("m/s", spare=9),
)


def tables(suite: Suite, evaluations: Sequence[Evaluation], names: Sequence[str] | None = None) -> list[Grid]:
    """Return the paper's tables if several policies were evaluated on its suite, else one table of all results.

    Notes below the last one say whose figures the paper's are, and which policies have equal names or contents.
    Without `names` policies are called as `names_of` has it.
    """
    names = names_of(evaluations) if names is None else names
    notes = list(notes_on_names(evaluations, names))
    if suite.tables and len(evaluations) > 1:
        grids = paper_tables(suite, evaluations, names)
        notes[:0] = [PAPER_TABLES_NOTE] if is_of_the_paper(evaluations[0]) else []
    else:
        grids = [results_grid(evaluations, names)]
    return [*grids[:-1], replace(grids[-1], notes=(*grids[-1].notes, *notes))]


def results_grid(evaluations: Sequence[Evaluation], names: Sequence[str] | None = None) -> Grid:
    """Return a table of evaluations in one suite, with a line for each on how its trials failed."""
    names = names_of(evaluations) if names is None else names
    several = len(evaluations) > 1
    rows = [
        (name if several else "", *_cells(case))
        for name, evaluation in zip(names, evaluations, strict=True)
        for case in evaluation.cases
    ]
    published = published_note(evaluations[0])
    notes = [published] if published else []
    notes += [
        f"{name}: {failures(evaluation)}" if several else failures(evaluation)
        for name, evaluation in zip(names, evaluations, strict=True)
    ]
    return Grid(title(evaluations), _COLUMNS, tuple(rows), tuple(notes)).without_empty_columns()


def title(evaluations: Sequence[Evaluation]) -> str:
    """Return what was evaluated and under which conditions."""
    first = evaluations[0]
    whose = f"{first.policy} in the suite" if len(evaluations) == 1 else "suite"
    parts = [f"{whose} {first.suite}", f"seed {first.seed}", str(first.acceptance)]
    if first.suite_acceptance is not None:
        parts[-1] += f" instead of the suite's {first.suite_acceptance}"
    if first.hold is not None:
        parts.append(f"then held for {first.hold.time_s:g} s within {first.hold.within_m:g} m")
    return ", ".join(parts)


def failures(evaluation: Evaluation) -> str:
    """Return how the trials of an evaluation failed, each once."""
    cases = evaluation.cases
    failed = evaluation.trials - evaluation.successes
    if not failed:
        return f"none of {evaluation.trials} trials failed"
    parts = [_plural(sum(case.falls for case in cases), "fall")]
    parts.append(_plural(sum(case.timeouts for case in cases), "time-out") + _how_late(cases))
    if strayed := sum(case.strayed or 0 for case in cases):
        parts.append(f"{strayed} strayed from the hold")
    return f"{failed} of {evaluation.trials} trials failed: {', '.join(parts)}"


def _how_late(cases: Sequence[CaseResult]) -> str:
    if not any(case.timeouts for case in cases) or any(case.late is None for case in cases):
        return ""
    kinds = {kind: sum(getattr(case, kind) for case in cases) for kind in ("orbiting", "stuck", "late")}
    return f" ({', '.join(f'{count} {kind}' for kind, count in kinds.items() if count)})"


def _plural(count: int, thing: str) -> str:
    return f"{count} {thing}{'' if count == 1 else 's'}"


def _cells(case: CaseResult) -> tuple[str, ...]:
    has_many_legs = case.legs is not None and case.legs > case.trials
    return (
        case.name,
        places(case.waypoints) if case.course is None else f"{case.course.count} random",
        f"{case.successes}/{case.trials}",
        percent(case.rate, 1),
        interval(case.wilson95),
        percent(case.paper),
        str(case.falls),
        str(case.timeouts),
        "" if not case.strayed else str(case.strayed),
        f"{case.legs_reached}/{case.legs}" if has_many_legs else "",
        "" if case.mean_time_s is None else f"{case.mean_time_s:.2f}",
        f"{case.spl:.3f}",
        "" if case.mean_speed_mps is None else f"{case.mean_speed_mps:.2f}",
    )
