"""The traffic of a mission: how the scripted operator sends commands, and at what times; how often telemetry comes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Final, Literal

from pydantic import BeforeValidator, Field, Strict, model_validator
from pydantic_core import PydanticCustomError

from waypointctl.mission.fields import DAY_S, Hold, Position, Timeout, Tolerance
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.units import bare_name


class OperatorScript(FileModel):
    """How the scripted operator behaves."""

    former_keys: ClassVar[Mapping[str, str]] = {"carrot": "lookahead"}

    think_s: Annotated[float, Quantity("s", ge=0, le=DAY_S)] = Field(
        0.0, description="between the telemetry that leads to a command and the command"
    )
    released: Annotated[int, Strict(), Field(ge=-1)] = Field(
        -1, description="autonomy mission: how many waypoints are released at first; -1 for all"
    )
    steering: Literal["move_and_wait", "continuous"] = Field(
        "move_and_wait",
        description="autonomy short_range_goal: with move_and_wait the next goal is sent when telemetry reports "
        "the end of the last, with continuous at update_rate",
    )
    lookahead_m: Annotated[float, Quantity("m", ge=0.1, le=100)] = Field(
        1.0, description="autonomy short_range_goal: how far ahead of the robot its short-range goal lies"
    )
    update_rate_hz: Annotated[float, Quantity("hz", ge=0.001, le=50)] = Field(
        1.0, description="autonomy short_range_goal, continuous: goals a second"
    )
    heartbeat_s: Annotated[float, Quantity("s", ge=0.02, le=DAY_S)] | None = Field(
        None, description="interval of heartbeats, by which the robot detects the loss of the link"
    )


class Commanding(FileModel):
    """How commands are sent again."""

    acknowledged: Annotated[bool, Strict()] = Field(
        True, description="whether a command is sent again until it is acknowledged"
    )
    retries: Annotated[int, Strict(), Field(ge=0, le=1000)] = Field(
        3, description="how often a command is sent again at most"
    )
    margin_s: Annotated[float, Quantity("s", ge=0, le=DAY_S)] = Field(
        1.0, description="how late an acknowledgement may be beyond round trip, jitter, rate and contacts"
    )


class TelemetryRate(FileModel):
    """How often the robot sends telemetry."""

    rate_hz: Annotated[float, Quantity("hz", ge=0.001, le=50)] = Field(5.0, description="frames a second")
    beacon_s: Annotated[float, Quantity("s", ge=1, le=DAY_S)] = Field(
        60.0, description="between frames while the robot is at rest"
    )


_LONGEST_S: Final = 100 * DAY_S
LARGEST_NUMBER: Final = 1_000_000_000  # of a command or of waypoints: no flight has as many

# What each command needs beside its time, and what it may have.
_NEEDS: Final[dict[str, str]] = {
    "go_to": "position_m",
    "set_tolerance": "tolerance_m",
    "set_timeout": "timeout_s",
    "cancel": "command",
    "release": "released",
}
_MAY_HAVE: Final[dict[str, tuple[str, ...]]] = {"go_to": ("tolerance_m", "timeout_s", "hold_s")}
_ARGUMENTS: Final = ("position_m", "tolerance_m", "timeout_s", "hold_s", "command", "released")

# What commands are called elsewhere, and at the console; what is merely misspelt is found by its letters.
_ELSEWHERE: Final[Mapping[str, tuple[str, ...]]] = {
    "stop": ("hold", "abort"),
    "halt": ("hold", "abort"),
    "pause": ("hold",),
    "wait": ("hold",),
    "loiter": ("hold",),
    "continue": ("resume",),
    "start": ("resume",),
    "goto": ("go_to",),
    "move": ("go_to",),
    "walk": ("go_to",),
    "next": ("skip",),
    "home": ("return_home",),
    "rth": ("return_home",),
    "rtl": ("return_home",),
    "tolerance": ("set_tolerance",),
    "timeout": ("set_timeout",),
}


def _known_here(do: object) -> object:
    """Return a command's name.

    Raises:
        PydanticCustomError: it is called otherwise here.
    """
    if isinstance(do, str) and (meant := _ELSEWHERE.get(do.lower().replace("-", "_"))):
        meanings = " or ".join(repr(name) for name in meant)
        problem = f"{do!r} is not a command; did you mean {meanings}?"
        raise PydanticCustomError("elsewhere", "{problem}", {"problem": problem})
    return do


class ScheduledCommand(FileModel):
    """A command and when it is sent, on the operator's clock."""

    at_s: Annotated[float, Quantity("s", ge=0, le=_LONGEST_S)] = Field(description="from mission start")
    do: Annotated[
        Literal[
            "go_to",
            "hold",
            "resume",
            "skip",
            "cancel",
            "abort",
            "set_tolerance",
            "set_timeout",
            "release",
            "return_home",
        ],
        BeforeValidator(_known_here),
    ] = Field(description="the command")
    position_m: Position | None = Field(None, description="go_to: x and y in the world frame")
    tolerance_m: Tolerance | None = Field(
        None, description="set_tolerance: of the waypoints still ahead; go_to: of this place"
    )
    timeout_s: Timeout | None = Field(
        None, description="set_timeout: of the waypoints still ahead; go_to: of this place"
    )
    hold_s: Hold | None = Field(None, description="go_to: how long to stay there")
    command: Annotated[int, Strict(), Field(ge=1, le=LARGEST_NUMBER)] | None = Field(
        None, description="cancel: the number of the command, from 1 in the order in which they were sent"
    )
    released: Annotated[int, Strict(), Field(ge=-1, le=LARGEST_NUMBER)] | None = Field(
        None, description="release: how many waypoints of the plan are released; -1 for all"
    )
    not_before_s: Annotated[float, Quantity("s", ge=0, le=_LONGEST_S)] | None = Field(
        None, description="on the robot's clock: it is executed then at the earliest"
    )
    expires_s: Annotated[float, Quantity("s", gt=0, le=_LONGEST_S)] | None = Field(
        None, description="on the robot's clock: it is not executed after that"
    )

    @model_validator(mode="after")
    def _has_what_it_needs(self) -> ScheduledCommand:
        given = [name for name in _ARGUMENTS if getattr(self, name) is not None]
        needed = _NEEDS.get(self.do)
        if needed is not None and needed not in given:
            raise ValueError(f"{self.do} needs '{bare_name(needed) or needed}'")
        for name in given:
            if name != needed and name not in _MAY_HAVE.get(self.do, ()):
                raise ValueError(f"{self.do} does not accept '{bare_name(name) or name}'")
        if self.expires_s is not None and self.expires_s <= self.at_s:
            raise ValueError(
                f"it expires at {self.expires_s:g} s, before it can be executed: it is sent at {self.at_s:g} s"
            )
        if self.expires_s is not None and self.expires_s <= (self.not_before_s or 0.0):
            raise ValueError(
                f"it expires at {self.expires_s:g} s, before it can be executed: not before {self.not_before_s:g} s"
            )
        return self
