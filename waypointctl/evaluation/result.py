"""The results of an evaluation: the JSON of `waypointctl eval` and of evaluation.json."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Final, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_serializer, model_validator

from waypointctl.errors import InputError
from waypointctl.evaluation.suite import Hold, RandomPaths, Training
from waypointctl.evaluation.wilson import wilson_interval
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.task.course import Deadline

EVALUATION: Final = "evaluation.json"  # its name in a policy's folder, for the paper's suite

Number: TypeAlias = Annotated[float, Field(allow_inf_nan=False)]
Count: TypeAlias = Annotated[int, Field(ge=0, le=10**15)]
Several: TypeAlias = Annotated[int, Field(gt=0, le=10**15)]
Rate: TypeAlias = Annotated[float, Field(ge=0, le=1)]
Name: TypeAlias = Annotated[str, Field(max_length=255)]
Point: TypeAlias = tuple[Number, Number]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True)


class CaseResult(_Record):
    """The results of a policy on one path, or on paths drawn in one way.

    What an evaluation of an earlier version did not measure is None.
    """

    name: Name
    waypoints: tuple[Point, ...]  # [m]; none where they were drawn
    trials: Several
    successes: Count  # all waypoints reached in time, and the last one held if the suite has `hold`
    rate: Rate
    wilson95: tuple[Rate, Rate]
    falls: Count
    timeouts: Count
    mean_time_s: Number | None  # from the start to the last waypoint, of the successes; None if there are none
    spl: Number  # success weighted by path length, mean over all trials
    paper: Rate | None  # the published rate, where there is one
    orbiting: Count | None = None  # of the time-outs, those that ended in an orbit around the waypoint
    stuck: Count | None = None  # of the time-outs, those that ended without moving; the others were late
    strayed: Count | None = None  # reached the last waypoint, but did not stay there: neither fall nor time-out
    legs: Several | None = None  # legs that were started
    legs_reached: Count | None = None  # of those, the ones whose waypoint was reached
    mean_leg_time_s: Number | None = None  # of the legs that were reached, in all trials
    mean_speed_mps: Number | None = None  # of the successes: total distance to the last waypoint divided by total time
    course: RandomPaths | None = None  # how the paths were drawn; None where they were given

    @model_validator(mode="after")
    def _counts_agree(self) -> CaseResult:
        if self.successes > self.trials:
            raise ValueError(f"{self.successes} successes are more than the {self.trials} trials")
        return self

    @field_serializer("course")
    def _as_the_suite_has_it(self, course: RandomPaths | None) -> dict[str, object] | None:
        return None if course is None else course.model_dump(mode="json", exclude_unset=True)

    @property
    def late(self) -> int | None:
        """Of the time-outs, those that were neither orbiting nor stuck."""
        if self.orbiting is None or self.stuck is None:
            return None
        return self.timeouts - self.orbiting - self.stuck


class Evaluation(_Record):
    """The results of a policy in a suite."""

    policy: Name
    suite: Name
    seed: int
    cases: Annotated[tuple[CaseResult, ...], Field(min_length=1)]
    acceptance: Acceptance
    deadline: Deadline
    policy_sha256: str
    versions: dict[str, str]
    start: Start = Start()
    hold: Hold | None = None
    suite_acceptance: Acceptance | None = None  # the suite's own, if another one was used
    observation: str | None = None  # the policy's observation layout
    training: Training | None = None  # what the policy was trained on, if its recipe states it

    @property
    def trials(self) -> int:
        """Of all cases together."""
        return sum(case.trials for case in self.cases)

    @property
    def successes(self) -> int:
        """Of all cases together."""
        return sum(case.successes for case in self.cases)

    @property
    def rate(self) -> float:
        """Of all cases together."""
        return self.successes / self.trials

    @property
    def wilson95(self) -> tuple[float, float]:
        """The interval of `rate`."""
        return wilson_interval(self.successes, self.trials)

    @property
    def conditions(self) -> str:
        """The suite's name, with the acceptance if it is not the suite's own."""
        return self.suite if self.suite_acceptance is None else f"{self.suite}, {self.acceptance}"

    def to_json(self) -> str:
        """Return the evaluation as indented JSON, the same text for the same evaluation."""
        return f"{self.model_dump_json(indent=2)}\n"


def evaluations_json(evaluations: Sequence[Evaluation]) -> str:
    """Return one evaluation as it is, several as {"evaluations": [...]}."""
    if len(evaluations) == 1:
        return evaluations[0].to_json()
    records = [evaluation.model_dump(mode="json") for evaluation in evaluations]
    return f"{json.dumps({'evaluations': records}, indent=2, ensure_ascii=False)}\n"


def read_evaluation(path: Path) -> Evaluation:
    """Read an evaluation that `write_evaluation` wrote; fields of later versions are left out.

    Raises:
        InputError: the file cannot be read or is not an evaluation.
    """
    hint = "write it again with `waypointctl eval POLICY --save`"
    content = read_input(path, RECORD_FILE, within=path.parent, hint=hint)
    try:
        return Evaluation.model_validate_json(content)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        place = ".".join(str(part) for part in fault["loc"])
        problem = f"not an evaluation: {place}{': ' if place else ''}{fault['msg']}"
        raise InputError(problem, where=str(path), hint=hint) from error
