"""The mean speed of a policy, from the evaluations in its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pydantic import BaseModel, Field

from waypointctl.errors import InputError
from waypointctl.input_file import RECORD_FILE, read_input

_FILES: Final = ("evaluation-region.json", "evaluation.json")  # the first with a speed is used
_USUAL_MPS: Final = 2.0


class _Case(BaseModel):
    """The fields of a CaseResult for the speed; importing the whole record would load the simulator."""

    successes: int = Field(ge=0)
    mean_time_s: float | None = Field(None, ge=0, allow_inf_nan=False)
    mean_speed_mps: float | None = Field(None, ge=0, allow_inf_nan=False)


class _Evaluation(BaseModel):
    cases: tuple[_Case, ...]


def mean_speed_of(policy: Path) -> float:
    """Return the mean speed of the policy in a folder, over its successes in the suite `region`, else `paper`.

    It is 2 m/s where no evaluation states it.
    """
    for name in _FILES:
        try:
            evaluation = _Evaluation.model_validate_json(read_input(policy / name, RECORD_FILE, within=policy))
        except (InputError, ValueError):  # not there, or none
            continue
        if (mps := _mean_mps(evaluation.cases)) is not None:
            return mps
    return _USUAL_MPS


def _mean_mps(cases: tuple[_Case, ...]) -> float | None:
    """Return the mean speed over all successes [m/s]: all metres by all seconds; None where none was measured."""
    metres = seconds = 0.0
    for case in cases:
        if case.mean_speed_mps is not None and case.mean_time_s is not None:
            spent_s = case.successes * case.mean_time_s
            metres, seconds = metres + case.mean_speed_mps * spent_s, seconds + spent_s
    return metres / seconds if seconds and metres else None
