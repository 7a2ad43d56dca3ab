"""What an evaluation found: the JSON of `waypointctl eval` and of evaluation.json."""

from __future__ import annotations

from pathlib import Path
from typing import Final, TypeAlias

from pydantic import BaseModel, ConfigDict, ValidationError

from waypointctl.errors import InputError, OutputError
from waypointctl.evaluation.suite import AcceptanceSpec, DeadlineSpec

EVALUATION: Final = "evaluation.json"  # its name in a policy's folder

Point: TypeAlias = tuple[float, float]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True)


class CaseResult(_Record):
    """How often and how well a policy walked one path."""

    name: str
    waypoints: tuple[Point, ...]  # [m]
    trials: int
    successes: int  # all waypoints reached in time
    rate: float
    wilson95: tuple[float, float]
    falls: int
    timeouts: int
    mean_time_s: float | None  # of the successes; None if there are none
    spl: float  # success weighted by path length, mean over all trials
    paper: float | None  # the published rate, where there is one


class Evaluation(_Record):
    """How a policy did in a suite."""

    policy: str
    suite: str
    seed: int
    cases: tuple[CaseResult, ...]
    acceptance: AcceptanceSpec
    deadline: DeadlineSpec
    policy_sha256: str
    versions: dict[str, str]

    def to_json(self) -> str:
        """Return the evaluation as indented JSON, the same text for the same evaluation."""
        return f"{self.model_dump_json(indent=2)}\n"


def write_evaluation(evaluation: Evaluation, path: Path) -> None:
    """Write the evaluation as JSON.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        path.write_text(evaluation.to_json(), encoding="utf-8")
    except OSError as error:
        problem = f"the evaluation cannot be written: {error.strerror}"
        raise OutputError(problem, where=str(path), mend="give a file in a folder that you can write to") from error


def read_evaluation(path: Path) -> Evaluation:
    """Read an evaluation that `write_evaluation` wrote; fields of later versions are left out.

    Raises:
        InputError: the file cannot be read or is not an evaluation.
    """
    mend = "write it again with `waypointctl eval POLICY --out evaluation.json`"
    try:
        return Evaluation.model_validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=str(path), mend=mend) from error
    except ValidationError as error:
        problem = f"not an evaluation: {error.errors(include_url=False)[0]['msg']}"
        raise InputError(problem, where=str(path), mend=mend) from error
