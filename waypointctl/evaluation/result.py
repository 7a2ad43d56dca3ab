"""The results of an evaluation: the JSON of `waypointctl eval` and of evaluation.json."""

from __future__ import annotations

import json
import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path
from statistics import NormalDist
from typing import Annotated, Final, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_serializer, model_validator

from waypointctl.errors import InputError
from waypointctl.evaluation.suite import Hold, RandomPaths, Training
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.task.course import Deadline


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the interval (low, high) in which the true rate lies with the given confidence.

    Unlike the normal approximation it stays within [0, 1] and is meaningful for 0 or all of `trials`
    (E. B. Wilson 1927; method 3 in R. G. Newcombe, Statistics in Medicine 17, 1998).

    Raises:
        ValueError: not 0 <= successes <= trials, or no trials.
    """
    if not 0 <= successes <= trials or trials == 0:
        raise ValueError(f"{successes} of {trials} is not a rate")
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    rate = successes / trials
    centre = rate + z * z / (2 * trials)
    half = z * math.sqrt(rate * (1 - rate) / trials + z * z / (4 * trials * trials))
    scale = 1 + z * z / trials
    low = 0.0 if successes == 0 else (centre - half) / scale  # exactly, where rounding would leave 1e-17
    high = 1.0 if successes == trials else (centre + half) / scale
    return low, high


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
    """Read an evaluation that `write_evaluations` wrote; fields of later versions are left out.

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


def names_of(evaluations: Sequence[Evaluation], folders: Sequence[Path] | None = None) -> list[str]:
    """Return what each policy is called: its name, where others have the same name its folder.

    Without folders the beginning of its hash is added; equal names are numbered.
    """
    known = Counter(evaluation.policy for evaluation in evaluations)
    names = [
        evaluation.policy
        if known[evaluation.policy] == 1
        else _told_apart(evaluation, folders[place] if folders else None)
        for place, evaluation in enumerate(evaluations)
    ]
    return _numbered(names)


def notes_on_names(evaluations: Sequence[Evaluation], names: Sequence[str]) -> tuple[str, ...]:
    """Return a line on each group of policies that are one and the same, and on each name that several go by."""
    by_content, by_name = defaultdict(list), defaultdict(set)
    for evaluation, name in zip(evaluations, names, strict=True):
        by_content[evaluation.policy_sha256].append(name)
        by_name[evaluation.policy].add(evaluation.policy_sha256)
    same = [
        f"{_listed(group)} are one and the same policy: SHA-256 {content[:7]}..."
        for content, group in by_content.items()
        if len(group) > 1
    ]
    clashing = [
        f"{len(contents)} different policies are called {name!r}"
        for name, contents in by_name.items()
        if len(contents) > 1
    ]
    return (*same, *clashing)


def _told_apart(evaluation: Evaluation, folder: Path | None) -> str:
    return f"{evaluation.policy} {evaluation.policy_sha256[:7]}" if folder is None else str(folder)


def _numbered(names: Sequence[str]) -> list[str]:
    """Return the names, those that are there more than once with a number."""
    counts = Counter(names)
    numbers = {name: iter(range(1, count + 1)) for name, count in counts.items()}
    return [f"{name} ({next(numbers[name])})" if counts[name] > 1 else name for name in names]


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"
