"""Whose figures stand under 'paper' in a table."""

from __future__ import annotations

from typing import Final

from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.suite import load_suite

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
    """Return whether an evaluation's cases are the paper's: a suite of somebody else's may have its name."""
    if evaluation.suite != _PAPER:
        return False
    theirs = {(case.path, case.paper) for case in load_suite(_PAPER).cases}
    return all((case.waypoints, case.paper) in theirs for case in evaluation.cases)
