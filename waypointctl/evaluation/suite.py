"""A suite: the paths that a policy is tested on, and when a trial is a success."""

from __future__ import annotations

from collections import Counter
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, model_validator

from waypointctl.errors import SuiteError, given_path
from waypointctl.mission.fields import DAY_S, Acceptance, Name, Position, RobotName, Start, Tolerance
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.policy_name import from_folder
from waypointctl.mission.quantity import Quantity
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.seeding import stream
from waypointctl.task.course import Course, Deadline, Point

FloatArray: TypeAlias = NDArray[np.float64]
Rate: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1)]
Training: TypeAlias = Literal["single point", "waypoints"]

BUILT_IN: Final = ("paper", "region", "anywhere", "station")
MOST_TRIALS: Final = 100_000


class Case(FileModel):
    """One path, the same in every trial."""

    name: Name
    waypoints: Annotated[tuple[Point, ...], Field(min_length=1, max_length=1000)] = Field(
        description="in the order in which they are to be reached"
    )
    paper: Rate | None = Field(None, description="the published success rate")

    @property
    def path(self) -> tuple[Position, ...]:
        """The waypoints (x, y) [m]."""
        return tuple(point.position_m for point in self.waypoints)

    @property
    def longest(self) -> int:
        """The number of waypoints."""
        return len(self.waypoints)

    def trial_path(self, seed: int, stream_name: str, trial: int, start_m: Position) -> FloatArray:
        """Return the waypoints (m, 2) [m], the same for every trial."""
        return np.array(self.path)


class RandomPaths(Course):
    """Paths that are drawn, another for each trial."""

    name: Name

    def trial_path(self, seed: int, stream_name: str, trial: int, start_m: Position) -> FloatArray:
        """Return the waypoints (m, 2) [m] of one trial, whatever the other trials are."""
        return self.draw(stream(seed, stream_name, trial), np.array(start_m))


SuiteCase: TypeAlias = Case | RandomPaths


class Hold(FileModel):
    """Stand at the last waypoint: once it is reached, the standing controller drives the motors."""

    time_s: Annotated[float, Quantity("s", gt=0, le=DAY_S)] = Field(10.0, description="how long")
    within_m: Tolerance = Field(0.5, description="largest distance of the torso from the waypoint during that time")


class PaperPolicy(FileModel):
    """A policy of the paper: its training waypoints and its observation."""

    number: Annotated[int, Strict(), Field(ge=1, le=1000)]
    training: Training = Field(
        description="single point: the same waypoint in every episode; waypoints: drawn for each episode"
    )
    observation: Name = Field(description="the layout: state, state_noise, state_goal")
    paper: dict[Name, Rate] | None = Field(
        None, description="its published success rates by case; where left out, the cases' own"
    )


class PaperTable(FileModel):
    """A table of the paper: with one case it has a row for each policy, with one policy a row for each case."""

    title: Name
    policies: Annotated[tuple[int, ...], Field(min_length=1)] = Field(description="by number")
    cases: Annotated[tuple[Name, ...], Field(min_length=1)] = Field(description="by name")


class Suite(FileModel):
    """Paths, given or random, on each of which a policy has many trials."""

    name: Name
    description: Annotated[str, Field(max_length=4000)] = Field("", description="for people")
    robot: RobotName | None = Field(
        None,
        description="a robot that comes with waypointctl, or the path of a folder (./NAME), relative to this file; "
        "the policy's by its name unless given",
    )
    trials: Annotated[int, Strict(), Field(gt=0, le=MOST_TRIALS)] = Field(100, description="of each case, by default")
    acceptance: Acceptance = Acceptance()
    deadline: Deadline = Deadline()
    start: Start = Start()
    hold: Hold | None = Field(None, description="standing at the last waypoint; default: it only has to be reached")
    cases: Annotated[tuple[Case, ...], Field(min_length=1, max_length=1000)] = Field((), description="given paths")
    courses: Annotated[tuple[RandomPaths, ...], Field(min_length=1, max_length=1000)] = Field(
        (), description="random paths"
    )
    policies: tuple[PaperPolicy, ...] = Field((), description="of the paper that the suite is from")
    tables: tuple[PaperTable, ...] = Field((), description="of the paper that the suite is from")

    @property
    def all_cases(self) -> tuple[SuiteCase, ...]:
        """Given paths first, then random ones."""
        return (*self.cases, *self.courses)

    def accepting(self, acceptance: Acceptance) -> Suite:
        """Return the suite with another acceptance region."""
        return self.model_copy(update={"acceptance": acceptance})

    @model_validator(mode="after")
    def _tests_something(self) -> Suite:
        if not self.all_cases:
            raise ValueError("a suite needs 'cases', 'courses' or both")
        return self

    @model_validator(mode="after")
    def _names_are_unique(self) -> Suite:
        counts = Counter(case.name for case in self.all_cases)
        if twice := [name for name, count in counts.items() if count > 1]:
            raise ValueError(f"each case needs its own name; used more than once: {', '.join(twice)}")
        return self

    @model_validator(mode="after")
    def _tables_name_what_there_is(self) -> Suite:
        numbers, names = {policy.number for policy in self.policies}, {case.name for case in self.cases}
        for table in self.tables:
            if unknown := [str(number) for number in table.policies if number not in numbers]:
                raise ValueError(
                    f"tables: {table.title!r} names the policy {unknown[0]}, which 'policies' does not have"
                )
            if strange := [name for name in table.cases if name not in names]:
                raise ValueError(f"tables: {table.title!r} names the case {strange[0]!r}, which 'cases' does not have")
        shown = {number for table in self.tables for number in table.policies}
        if self.tables and (missing := sorted(numbers - shown)):
            raise ValueError(f"tables: the policy {missing[0]} stands in none of them, so its results would not either")
        return self


def load_suite(name_or_file: Path | str) -> Suite:
    """Return a suite that comes with waypointctl, by its name, or the one in a YAML file.

    Raises:
        SuiteError: the suite or file does not exist, or the file is not a suite.
        InputError: the argument is neither a name nor a path.
    """
    path = given_path("name_or_file", name_or_file, "a suite's file, or its name")
    if name_or_file in BUILT_IN:
        source = files("waypointctl.evaluation").joinpath("suites", f"{name_or_file}.yaml").read_bytes()
        return read_model(source, f"{name_or_file}.yaml", Suite, SuiteError)
    try:
        source = read_source(path, SuiteError)
    except SuiteError as error:
        hint = f"give a YAML file, or a suite that comes with waypointctl: {', '.join(BUILT_IN)}"
        raise SuiteError(error.problem, where=error.where, hint=hint) from error
    suite = read_model(source, str(name_or_file), Suite, SuiteError)
    robot = suite.robot and from_folder(suite.robot, path.parent)
    return suite.model_copy(update={"robot": robot})


def suite_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of a suite, with every spelling that is read."""
    from waypointctl.mission.file_model import model_schema

    return model_schema(Suite, "waypointctl suite")
