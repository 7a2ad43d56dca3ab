"""Policies and what they achieve, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from waypointctl.evaluation.catalogue import Entry
    from waypointctl.evaluation.grid import Grid
    from waypointctl.evaluation.result import CaseResult, Evaluation

_LONG: Final = 4  # waypoints; of longer paths the legs are shown, too


def policies_grid(entries: Sequence[Entry]) -> Grid:
    """Return a row for each policy, with a column for each suite that any of them has been evaluated in."""
    from waypointctl.evaluation.grid import Column, Grid

    suites = list(dict.fromkeys(evaluation.conditions for entry in entries for evaluation in entry.evaluations))
    columns = (
        Column("policy", is_text=True),
        Column("robot", is_text=True, spare=len(suites) + 3),
        Column("layout", is_text=True, spare=len(suites) + 2),
        Column("steps", spare=len(suites) + 1),
        *(Column(suite, is_text=True, spare=place) for place, suite in enumerate(suites or ["results"])),
    )
    return Grid("", columns, tuple(_row(entry, suites) for entry in entries))


def result_text(evaluation: Evaluation) -> str:
    """Return what an evaluation came to, in a few words."""
    if len(evaluation.cases) > 1:
        rates = [case.rate for case in evaluation.cases]
        low, high = f"{min(rates) * 100:.0f}", f"{max(rates):.0%}"
        return f"{high if min(rates) == max(rates) else f'{low}-{high}'} in {len(rates)} cases"
    (case,) = evaluation.cases
    return f"{case.rate:.1%}{_legs_text(case)}"


def _legs_text(case: CaseResult) -> str:
    """Return the rate of legs on long random paths, where it differs from that of whole paths."""
    if case.course is None or case.course.count <= _LONG or case.legs is None or case.legs_reached is None:
        return ""
    return f", legs {case.legs_reached / case.legs:.2%}"


def _row(entry: Entry, suites: Sequence[str]) -> tuple[str, ...]:
    where = f"{entry.name} (shipped)" if entry.shipped else str(entry.folder)
    if entry.policy is None:
        return (where, "", "", "", *_padded("damaged", suites))
    manifest = entry.policy.manifest
    found = {evaluation.conditions: result_text(evaluation) for evaluation in entry.evaluations}
    results = [found.get(suite, "") for suite in suites] if found else _padded("not evaluated", suites)
    steps = f"{manifest.training.steps:,}"
    return (where, manifest.robot, manifest.observation.layout, steps, *results)


def _padded(word: str, suites: Sequence[str]) -> list[str]:
    return [word, *([""] * (len(suites) - 1))]
