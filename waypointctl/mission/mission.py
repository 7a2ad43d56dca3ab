"""The mission: waypoints, link, operator, rules on board, and what counts as a success.

Units are in the names: [m], [s], [deg], [Hz]; positions are (x, y) in the world frame, heading 0 looks along x.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PrivateAttr,
    Strict,
    ValidationInfo,
    field_validator,
    model_validator,
)

from waypointctl.mission.checks import (
    SCHEMA_VERSION,
    expected_within,
    file_name,
    known_version,
    names_differ,
    possible,
)
from waypointctl.mission.fields import (
    DAY_S,
    AcceptanceShape,
    Hold,
    Name,
    Position,
    RobotName,
    Start,
    Timeout,
    Tolerance,
    line_of_text,
)
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.link import Link
from waypointctl.mission.onboard import Onboard, OnFailure
from waypointctl.mission.operator import Commanding, OperatorScript, ScheduledCommand, TelemetryRate
from waypointctl.mission.quantity import Quantity

MOST_LEGS: Final = 10_000


class Defaults(FileModel):
    """Values for every waypoint that does not set its own."""

    acceptance: AcceptanceShape = Field(
        "box", description="box: |dx| and |dy| within the tolerance; radius: the distance"
    )
    tolerance_m: Tolerance = Field(0.5, description="half the side of the box, or the radius")
    timeout_s: Timeout = Field(30.0, description="from the start of the leg until the waypoint must be reached")
    hold_s: Hold = Field(0.0, description="how long to stay at the waypoint")
    observe: Annotated[bool, Strict()] = Field(False, description="whether to take a picture there, after the hold")


class Waypoint(FileModel):
    """A place to reach; what is left out is taken from the mission's defaults. A bare [x, y] is the position."""

    list_shorthand: ClassVar[str | None] = "position_m"

    name: Name | None = Field(None, description="WP1, WP2, ... where it is left out")
    position_m: Position = Field(description="x and y in the world frame")
    acceptance: AcceptanceShape | None = Field(
        None, description="box: |dx| and |dy| within the tolerance; radius: the distance"
    )
    tolerance_m: Tolerance | None = Field(None, description="half the side of the box, or the radius")
    timeout_s: Timeout | None = Field(None, description="from the start of the leg until the waypoint must be reached")
    hold_s: Hold | None = Field(None, description="how long to stay at the waypoint")
    observe: Annotated[bool, Strict()] | None = Field(
        None, description="whether to take a picture there, after the hold"
    )


def _named_apart(waypoints: tuple[Waypoint, ...]) -> tuple[Waypoint, ...]:
    names_differ([name_of(index, waypoint) for index, waypoint in enumerate(waypoints)])
    return waypoints


class Expect(FileModel):
    """What has to be reached for the mission to count as a success."""

    reached: Literal["all"] | Annotated[int, Strict(), Field(ge=0)] = Field(
        "all", description="how many waypoints, at least"
    )
    max_time_s: Annotated[float, Quantity("s", gt=0, le=100 * DAY_S)] | None = Field(
        None, description="from mission start"
    )


class Mission(FileModel):
    """Waypoints, and how the robot is commanded to reach them."""

    schema_version: Annotated[Literal[2], BeforeValidator(known_version)] = Field(
        SCHEMA_VERSION, description="version of the file format"
    )
    name: Annotated[str, Field(min_length=1, max_length=80), AfterValidator(file_name)] = Field(
        description="letters, digits, '.', '_', '-' and spaces: it names the log"
    )
    description: Annotated[str, Field(max_length=4000)] = Field("", description="free text for readers")
    seed: Annotated[int, Strict(), Field(ge=0, lt=2**63)] = Field(0, description="seed of all random draws")
    robot: RobotName = Field(
        "ant",
        description="a robot that comes with waypointctl, or a folder (./NAME), relative to this file",
    )
    policy: Annotated[str, Field(min_length=1, max_length=1000), AfterValidator(line_of_text)] = Field(
        description="the policy bundle's folder, relative to the mission file, or a name: ./policies/NAME, or one that "
        "comes with waypointctl, such as ant-waypoint"
    )
    start: Start = Start()
    autonomy: Literal["mission", "waypoint", "short_range_goal", "joint"] = Field(
        "mission",
        description="mission: the whole plan is sent at once; waypoint: one at a time, once the last has ended; "
        "short_range_goal: short-range goals, from the last reported pose; joint: every action, from the last "
        "reported state",
    )
    operator: OperatorScript = OperatorScript()
    commands: Commanding = Commanding()
    schedule: Annotated[tuple[ScheduledCommand, ...], Field(max_length=1000)] = Field(
        (), description="commands sent at given times"
    )
    defaults: Defaults = Defaults()
    waypoints: Annotated[tuple[Waypoint, ...], Field(min_length=1, max_length=1000), AfterValidator(_named_apart)] = (
        Field(description="in the order in which they are to be reached")
    )
    repeat: Annotated[int, Strict(), Field(ge=1, le=1000)] = Field(
        1, description="how often the waypoints are visited, one round after the other"
    )
    start_at: Name | None = Field(
        None, description="name of the waypoint to begin with; those before it are left out of the first round"
    )
    link: Link = Link()
    telemetry: TelemetryRate = TelemetryRate()
    on_failure: OnFailure | None = Field(None, description="what to do when a leg fails: abort where it is left out")
    onboard: Onboard = Field(Onboard(), description="rules that the robot applies by itself")
    expect: Expect = Expect()

    _files: Mapping[str, bytes] = PrivateAttr(default_factory=dict)

    @property
    def files(self) -> Mapping[str, bytes]:
        """The contents of the files that the mission refers to, by their names in it."""
        return self._files

    def with_files(self, files: Mapping[str, bytes]) -> Mission:
        """Return the mission with the contents of the files that it refers to; it is flown with these alone."""
        mission = self.model_copy()
        mission._files = dict(files)
        return mission

    @property
    def failure_rule(self) -> OnFailure:
        """What to do when a leg fails, from either place in the file."""
        return self.on_failure or self.onboard.on_failure or OnFailure()

    @field_validator("onboard")
    @classmethod
    def _one_failure_rule(cls, onboard: Onboard, info: ValidationInfo) -> Onboard:
        if onboard.on_failure is not None and info.data.get("on_failure") is not None:
            raise ValueError("'on_failure' is also given at the top of the mission: keep one")
        return onboard

    @field_validator("repeat")
    @classmethod
    def _not_too_many(cls, repeat: int, info: ValidationInfo) -> int:
        count = repeat * len(info.data.get("waypoints", ()))
        if count > MOST_LEGS:
            raise ValueError(f"{repeat} rounds are {count:,} legs; at most {MOST_LEGS:,} can be flown")
        return repeat

    @field_validator("start_at")
    @classmethod
    def _one_of_the_waypoints(cls, start_at: str | None, info: ValidationInfo) -> str | None:
        names = [name_of(index, waypoint) for index, waypoint in enumerate(info.data.get("waypoints", ()))]
        if start_at is not None and names and start_at not in names:
            raise ValueError(f"{start_at!r} is not a waypoint; waypoints are {', '.join(names)}")
        return start_at

    @field_validator("expect")
    @classmethod
    def _no_more_than_there_are(cls, expect: Expect, info: ValidationInfo) -> Expect:
        if all(name in info.data for name in ("waypoints", "repeat", "start_at")):  # else they are wrong already
            data = info.data
            expected_within(expect.reached, len(_order(data["waypoints"], data["repeat"], data["start_at"])))
        return expect

    @model_validator(mode="after")
    def _asks_for_what_can_be(self) -> Self:
        possible(self.schedule, self.operator.released, self.autonomy, self.num_legs)
        return self

    @property
    def num_legs(self) -> int:
        """How many waypoints are to be reached, in all rounds together."""
        return len(_order(self.waypoints, self.repeat, self.start_at))

    def legs(self) -> tuple[Leg, ...]:
        """Return the waypoints of all rounds with everything that they take from the defaults."""
        order = _order(self.waypoints, self.repeat, self.start_at)
        return tuple(self._leg(index, *place) for index, place in enumerate(order))

    def path_length_m(self) -> float:
        """Return the length of the straight path from the start through all legs, in [m]."""
        places = [self.start.position_m, *((leg.x_m, leg.y_m) for leg in self.legs())]
        return sum(math.dist(a, b) for a, b in itertools.pairwise(places))

    def _leg(self, index: int, number: int, at: int) -> Leg:
        waypoint, name = self.waypoints[at], name_of(at, self.waypoints[at])
        own = {field: getattr(waypoint, field) for field in Defaults.model_fields}
        taken = {field: getattr(self.defaults, field) if value is None else value for field, value in own.items()}
        x_m, y_m = waypoint.position_m
        return Leg(index, name if self.repeat == 1 else f"{name} ({number})", x_m, y_m, at=at, **taken)


@dataclass(frozen=True, slots=True)
class Leg:
    """A waypoint with nothing left open."""

    index: int  # from 0, through all rounds
    name: str
    x_m: float
    y_m: float
    acceptance: AcceptanceShape
    tolerance_m: float  # half the side of the box, or the radius
    timeout_s: float  # from the start of the leg
    hold_s: float
    observe: bool = False
    at: int = 0  # place of its waypoint in the file, from 0


def name_of(index: int, waypoint: Waypoint) -> str:
    """Return what a waypoint is called, by its place in the file where it has no name."""
    return waypoint.name if waypoint.name is not None else f"WP{index + 1}"


def _order(waypoints: Sequence[Waypoint], repeat: int, start_at: str | None) -> list[tuple[int, int]]:
    """Return the legs in order: the round, from 1, and the waypoint's place in the file."""
    names = [name_of(index, waypoint) for index, waypoint in enumerate(waypoints)]
    first = 0 if start_at is None else names.index(start_at)
    return [(1 + at // len(names), at % len(names)) for at in range(first, repeat * len(names))]
