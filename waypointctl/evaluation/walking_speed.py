"""How fast a policy walks, from the evaluations that are kept beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from waypointctl.errors import InputError
from waypointctl.evaluation.result import EVALUATION, CaseResult, read_evaluation
from waypointctl.ops.forecast.forecast import WalkingSpeed

_FILES: Final = ("evaluation-region.json", EVALUATION)  # the first that tells goes first
_USUAL_MPS: Final = 2.0


def walking_speed(policy: Path) -> WalkingSpeed:
    """Return the mean speed of a policy's successes in the suite `region`, else in `paper`; else 2 m/s, which it says.

    Args:
        policy: its folder.
    """
    for name in _FILES:
        try:
            evaluation = read_evaluation(policy / name)
        except (InputError, ValueError):  # not there, or none; a path can be one that cannot be
            continue
        if (mps := _mean_mps(evaluation.cases)) is not None:
            return WalkingSpeed(mps, f"the mean of {evaluation.policy} in the suite {evaluation.suite}")
    return WalkingSpeed(_USUAL_MPS, f"assumed, since no evaluation of {policy.name} tells its speed")


def _mean_mps(cases: tuple[CaseResult, ...]) -> float | None:
    """Return the mean speed over all successes [m/s]: all metres by all seconds; None where none was measured."""
    metres = seconds = 0.0
    for case in cases:
        if case.mean_speed_mps is not None and case.mean_time_s is not None:
            spent_s = case.successes * case.mean_time_s
            metres, seconds = metres + case.mean_speed_mps * spent_s, seconds + spent_s
    return metres / seconds if seconds and metres else None
