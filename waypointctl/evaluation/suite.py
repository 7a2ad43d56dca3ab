"""What a policy is tested on: paths to walk, and when a trial is a success."""

from __future__ import annotations

from collections import Counter
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Final, TypeAlias

from pydantic import Field, Strict, model_validator

from waypointctl.errors import SuiteError
from waypointctl.evaluation.conditions import Hold
from waypointctl.evaluation.paper import PaperPolicy, PaperTable
from waypointctl.evaluation.paths import Case, RandomPaths
from waypointctl.mission.fields import Acceptance, RobotName, Start
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Name
from waypointctl.mission.policy_name import from_folder
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.task.course import Deadline

BUILT_IN: Final = ("paper", "region", "anywhere", "station")
MOST_TRIALS: Final = 100_000

Walked: TypeAlias = Case | RandomPaths


class Suite(FileModel):
    """A list of paths, given or drawn, each of them walked in many trials."""

    name: Name
    description: Annotated[str, Field(max_length=4000)] = Field("", description="for people")
    robot: RobotName | None = Field(
        None,
        description="a robot that comes with waypointctl, or the path of a folder (./NAME), relative to this file; "
        "the policy's by its name unless given",
    )
    trials: Annotated[int, Strict(), Field(gt=0, le=MOST_TRIALS)] = Field(
        100, description="of each case, unless told otherwise"
    )
    acceptance: Acceptance = Acceptance()
    deadline: Deadline = Deadline()
    start: Start = Start()
    hold: Hold | None = Field(None, description="to stand at the last waypoint; left out: reaching it is enough")
    cases: Annotated[tuple[Case, ...], Field(min_length=1, max_length=1000)] = Field((), description="given paths")
    courses: Annotated[tuple[RandomPaths, ...], Field(min_length=1, max_length=1000)] = Field(
        (), description="random paths"
    )
    policies: tuple[PaperPolicy, ...] = Field((), description="of the paper that the suite is from")
    tables: tuple[PaperTable, ...] = Field((), description="of the paper that the suite is from")

    @property
    def walked(self) -> tuple[Walked, ...]:
        """The cases, given ones first."""
        return (*self.cases, *self.courses)

    def accepting(self, acceptance: Acceptance) -> Suite:
        """Return the suite with another acceptance region."""
        return self.model_copy(update={"acceptance": acceptance})

    @model_validator(mode="after")
    def _tests_something(self) -> Suite:
        if not self.walked:
            raise ValueError("a suite needs 'cases', 'courses' or both")
        return self

    @model_validator(mode="after")
    def _names_are_unique(self) -> Suite:
        counts = Counter(case.name for case in self.walked)
        if twice := [name for name, count in counts.items() if count > 1]:
            raise ValueError(f"each case needs a name of its own; more than one is called {', '.join(twice)}")
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


def load_suite(name_or_file: str) -> Suite:
    """Return a suite that comes with waypointctl, or the one in a YAML file.

    Raises:
        SuiteError: there is no such suite or file, or what is in the file is not a suite.
    """
    if name_or_file in BUILT_IN:
        source = files("waypointctl.evaluation").joinpath("suites", f"{name_or_file}.yaml").read_bytes()
        return read_model(source, f"{name_or_file}.yaml", Suite, SuiteError)
    try:
        source = read_source(Path(name_or_file), SuiteError)
    except SuiteError as error:
        hint = f"give a YAML file, or a suite that comes with waypointctl: {', '.join(BUILT_IN)}"
        raise SuiteError(error.problem, where=error.where, hint=hint) from error
    suite = read_model(source, name_or_file, Suite, SuiteError)
    robot = suite.robot and from_folder(suite.robot, Path(name_or_file).parent)
    return suite.model_copy(update={"robot": robot})


def suite_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of a suite, with every spelling that is read."""
    from waypointctl.mission.file_schema import model_schema

    return model_schema(Suite, "waypointctl suite")
