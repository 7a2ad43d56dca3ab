"""What a policy is tested on: paths to walk, and when a waypoint counts as reached."""

from __future__ import annotations

from collections import Counter
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from waypointctl.errors import SuiteError
from waypointctl.mission.mission import Hold, Position, Timeout, Tolerance  # a suite's bounds are a mission's
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.task.acceptance import Acceptance
from waypointctl.task.course import Deadline

BUILT_IN: Final = ("paper",)

Number: TypeAlias = Annotated[float, Field(strict=True, allow_inf_nan=False)]  # strict: true is not 1.0
Name: TypeAlias = Annotated[str, Field(min_length=1)]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class AcceptanceSpec(_Record):
    """The region around a waypoint: `size_m` is half the box's side, or the radius [m]."""

    shape: Literal["box", "radius"] = "box"
    size_m: Tolerance = 0.5

    def to_task(self) -> Acceptance:
        """Return it as the task takes it."""
        return Acceptance(self.shape, self.size_m)


class DeadlineSpec(_Record):
    """The time limit: `first_s` for the first waypoint, and `further_s` more for each one reached [s]."""

    first_s: Timeout = 10.0
    further_s: Hold = 20.0

    def to_task(self) -> Deadline:
        """Return it as the task takes it."""
        return Deadline(self.first_s, self.further_s)


class Case(_Record):
    """One path, from the origin through its waypoints."""

    name: Name
    waypoints: tuple[Position, ...]  # [m]
    paper: Annotated[Number, Field(ge=0, le=1)] | None = None  # the published success rate

    # Not Field(min_length=1): pydantic would also call a list too short whose items are wrong.
    @field_validator("waypoints")
    @classmethod
    def _leads_somewhere(cls, waypoints: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        if not waypoints:
            raise ValueError("a path needs at least one waypoint, [x, y] in m")
        return waypoints


class Suite(_Record):
    """A list of paths that every trial walks in the same way."""

    name: Name
    acceptance: AcceptanceSpec = AcceptanceSpec()
    deadline: DeadlineSpec = DeadlineSpec()
    cases: tuple[Case, ...]

    @field_validator("cases")
    @classmethod
    def _tests_something(cls, cases: tuple[Case, ...]) -> tuple[Case, ...]:
        if not cases:
            raise ValueError("a suite needs at least one case")
        return cases

    @model_validator(mode="after")
    def _names_are_unique(self) -> Suite:
        counts = Counter(case.name for case in self.cases)
        if twice := [name for name, count in counts.items() if count > 1]:
            raise ValueError(f"each case needs a name of its own; more than one is called {', '.join(twice)}")
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
        mend = f"give a YAML file, or a suite that comes with waypointctl: {', '.join(BUILT_IN)}"
        raise SuiteError(error.problem, where=error.where, mend=mend) from error
    return read_model(source, name_or_file, Suite, SuiteError)
