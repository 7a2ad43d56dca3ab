"""Commands that the operator sends at given times, whatever else it does."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Field, Strict, model_validator

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity

_DAY_S: Final = 86_400.0
_LONGEST_S: Final = 100 * _DAY_S

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


class ScheduledCommand(FileModel):
    """A command and when it is sent, on the operator's clock."""

    at_s: Annotated[float, Quantity("s", ge=0, le=_LONGEST_S)] = Field(description="from mission start")
    do: Literal[
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
    command: Annotated[int, Strict(), Field(ge=1)] | None = Field(
        None, description="cancel: the number of the command, from 1 in the order in which they were sent"
    )
    released: Annotated[int, Strict(), Field(ge=-1)] | None = Field(
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
            raise ValueError(f"{self.do} needs '{needed}'")
        for name in given:
            if name != needed and name not in _MAY_HAVE.get(self.do, ()):
                raise ValueError(f"'{name}' is nothing for {self.do}")
        if self.expires_s is not None and self.expires_s <= max(self.at_s, self.not_before_s or 0.0):
            raise ValueError(f"it expires at {self.expires_s:g} s, before it can be obeyed")
        return self
