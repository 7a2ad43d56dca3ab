"""Commands that the operator sends at given times, whatever else it does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Final, Literal

from pydantic import BeforeValidator, Field, Strict, model_validator
from pydantic_core import PydanticCustomError

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.units import bare_name

_DAY_S: Final = 86_400.0
_LONGEST_S: Final = 100 * _DAY_S
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
        said = " or ".join(repr(name) for name in meant)
        problem = f"{do!r} is not a command; did you mean {said}?"
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
    ] = Field(description="what the robot is told")
    position_m: (
        tuple[
            Annotated[float, Quantity("m", ge=-10_000, le=10_000)],
            Annotated[float, Quantity("m", ge=-10_000, le=10_000)],
        ]
        | None
    ) = Field(None, description="go_to: x and y in the world frame")
    tolerance_m: Annotated[float, Quantity("m", gt=0, le=100)] | None = Field(
        None, description="set_tolerance: of the waypoints to come; go_to: of this place"
    )
    timeout_s: Annotated[float, Quantity("s", gt=0, le=_DAY_S)] | None = Field(
        None, description="set_timeout: of the waypoints to come; go_to: of this place"
    )
    hold_s: Annotated[float, Quantity("s", ge=0, le=_DAY_S)] | None = Field(
        None, description="go_to: how long to stand there"
    )
    command: Annotated[int, Strict(), Field(ge=1, le=LARGEST_NUMBER)] | None = Field(
        None, description="cancel: the number of the command, from 1 in the order in which they were sent"
    )
    released: Annotated[int, Strict(), Field(ge=-1, le=LARGEST_NUMBER)] | None = Field(
        None, description="release: how many waypoints of the plan the robot may walk to; -1 for all"
    )
    not_before_s: Annotated[float, Quantity("s", ge=0, le=_LONGEST_S)] | None = Field(
        None, description="on the robot's clock: it waits until then"
    )
    expires_s: Annotated[float, Quantity("s", gt=0, le=_LONGEST_S)] | None = Field(
        None, description="on the robot's clock: it is not obeyed after that"
    )

    @model_validator(mode="after")
    def _has_what_it_needs(self) -> ScheduledCommand:
        given = [name for name in _ARGUMENTS if getattr(self, name) is not None]
        needed = _NEEDS.get(self.do)
        if needed is not None and needed not in given:
            raise ValueError(f"{self.do} needs '{bare_name(needed) or needed}'")
        for name in given:
            if name != needed and name not in _MAY_HAVE.get(self.do, ()):
                raise ValueError(f"'{bare_name(name) or name}' is nothing for {self.do}")
        if self.expires_s is not None and self.expires_s <= self.at_s:
            raise ValueError(
                f"it expires at {self.expires_s:g} s, before it can be obeyed: it is sent at {self.at_s:g} s"
            )
        if self.expires_s is not None and self.expires_s <= (self.not_before_s or 0.0):
            raise ValueError(
                f"it expires at {self.expires_s:g} s, before it can be obeyed: not before {self.not_before_s:g} s"
            )
        return self
