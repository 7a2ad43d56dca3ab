"""The tables of a suite's paper, with the published rates next to the measured ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from waypointctl.evaluation.grid import Column, Grid, interval, percent, places
from waypointctl.evaluation.result import CaseResult, Evaluation, names_of
from waypointctl.evaluation.suite import Case, PaperPolicy, PaperTable, Suite, load_suite

_ARROW: Final = " → "
_INTERVAL: Final = "95 % CI [%]"
_PAPER: Final = "paper"
_AUTHORS: Final = "Blum, Jones and Yoshida"
_TRIALS: Final = 10  # that their rates are of

PAPER_TABLES_NOTE: Final = f"{_PAPER}: the rates that {_AUTHORS} report, each of {_TRIALS} trials"


def published_note(evaluation: Evaluation) -> str | None:
    """Return a line on where the published rates of an evaluation's cases are from, None if no case has one."""
    if all(case.paper is None for case in evaluation.cases):
        return None
    if is_of_the_paper(evaluation):
        return f"{_PAPER}: the rate that {_AUTHORS} report for their policy 5, of {_TRIALS} trials"
    return f"{_PAPER}: the published rate that the suite gives for a case"


def is_of_the_paper(evaluation: Evaluation) -> bool:
    """Return whether an evaluation's cases are the paper's: a user's suite may have the same name."""
    if evaluation.suite != _PAPER:
        return False
    theirs = {(case.path, case.paper) for case in load_suite(_PAPER).cases}
    return all((case.waypoints, case.paper) in theirs for case in evaluation.cases)


@dataclass(frozen=True, slots=True)
class _Entrant:
    """A policy of the paper, one that was evaluated, or both."""

    name: str
    of_paper: PaperPolicy | None
    evaluation: Evaluation | None


def number_of(suite: Suite, evaluation: Evaluation) -> int | None:
    """Return which of the paper's policies an evaluated one is, by its observation and its training; None: none."""
    for policy in suite.policies:
        if (policy.observation, policy.training) == (evaluation.observation, evaluation.training):
            return policy.number
    return None


def paper_tables(suite: Suite, evaluations: Sequence[Evaluation], names: Sequence[str] | None = None) -> list[Grid]:
    """Return the paper's tables in its own layout, with the measured rates next to the published ones.

    A policy that is none of the paper's has a row, or a column, of its own. Of the paper's policies a table shows
    those that it has in the paper, whether they were evaluated or not.
    Without `names` policies are called as `names_of` has it.
    """
    names = names_of(evaluations) if names is None else names
    return [_table(suite, table, evaluations, names) for table in suite.tables]


def entrants(
    suite: Suite, table: PaperTable, evaluations: Sequence[Evaluation], names: Sequence[str]
) -> list[tuple[str, Evaluation]]:
    """Return the evaluated policies that belong into a table, with what they are called: the paper's first."""
    found = _entrants(suite, table, evaluations, names)
    return [(entrant.name, entrant.evaluation) for entrant in found if entrant.evaluation is not None]


def _entrants(
    suite: Suite, table: PaperTable, evaluations: Sequence[Evaluation], names: Sequence[str]
) -> list[_Entrant]:
    numbered = [(number_of(suite, evaluation), evaluation) for evaluation in evaluations]
    named = list(zip(names, numbered, strict=True))
    found = []
    for policy in suite.policies:
        if policy.number in table.policies:
            ours = [_Entrant(name, policy, evaluation) for name, (n, evaluation) in named if n == policy.number]
            found += ours or [_Entrant("", policy, None)]
    return found + [_Entrant(name, None, evaluation) for name, (number, evaluation) in named if number is None]


def _table(suite: Suite, table: PaperTable, evaluations: Sequence[Evaluation], names: Sequence[str]) -> Grid:
    cases = [case for name in table.cases for case in suite.cases if case.name == name]
    found = _entrants(suite, table, evaluations, names)
    return _by_policy(table, cases, found) if len(table.policies) > 1 else _by_case(table, cases, found)


def _by_policy(table: PaperTable, cases: Sequence[Case], found: Sequence[_Entrant]) -> Grid:
    columns = (
        Column("#"),
        Column("policy", is_text=True),
        Column("training", is_text=True, spare=1),
        Column("observation", is_text=True, spare=2),
        Column("path", is_text=True),
        Column("paper"),
        Column("success"),
        Column(_INTERVAL),
        Column("falls", spare=3),
        Column("time-outs", spare=4),
    )
    title = table.title
    if len(cases) == 1:
        title += f": {places(cases[0].path, _ARROW)}"
    rows = [_policy_row(entrant, case, len(cases) > 1) for entrant in found for case in cases]
    return Grid(title, columns, tuple(rows)).without_empty_columns()


def _policy_row(entrant: _Entrant, case: Case, with_path: bool) -> tuple[str, ...]:
    of_paper, result = entrant.of_paper, _result(entrant.evaluation, case)
    described = of_paper or entrant.evaluation
    assert described is not None
    return (
        str(of_paper.number) if of_paper else "",
        entrant.name,
        described.training or "",
        (described.observation or "").replace("_", " + "),
        places(case.path, _ARROW) if with_path else "",
        percent(_figure(of_paper, case)),
        _success(result),
        interval(result.wilson95) if result else "",
        str(result.falls) if result else "",
        str(result.timeouts) if result else "",
    )


def _by_case(table: PaperTable, cases: Sequence[Case], found: Sequence[_Entrant]) -> Grid:
    of_paper = next(entrant.of_paper for entrant in found if entrant.of_paper is not None)
    columns = [Column("path", is_text=True), Column("paper")]
    for place, entrant in enumerate(found):
        whose = entrant.name or "success"
        columns += [Column(whose, spare=place), Column(_INTERVAL, spare=len(found) + place, of=whose)]
    rows = []
    for case in cases:
        row = [places(case.path, _ARROW), percent(_figure(of_paper, case))]
        for entrant in found:
            result = _result(entrant.evaluation, case)
            row += [_success(result), interval(result.wilson95) if result else ""]
        rows.append(tuple(row))
    return Grid(f"{table.title}: the paper's policy {of_paper.number}", tuple(columns), tuple(rows))


def _figure(policy: PaperPolicy | None, case: Case) -> float | None:
    """Return the published rate of a policy in a case."""
    if policy is None:
        return None
    return case.paper if policy.paper is None else policy.paper.get(case.name)


def _result(evaluation: Evaluation | None, case: Case) -> CaseResult | None:
    cases = evaluation.cases if evaluation is not None else ()
    return next((result for result in cases if result.name == case.name), None)


def _success(result: CaseResult | None) -> str:
    return "not evaluated" if result is None else f"{result.successes}/{result.trials}"
