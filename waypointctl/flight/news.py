"""Which frame of telemetry is the first to tell how the robot stands now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from waypointctl.flight.executive.executive import Executive
from waypointctl.log.messages import CommandStatus, Mode, Telemetry

_Standing: TypeAlias = tuple[Mode, int, int, tuple[CommandStatus, ...], str]


@dataclass(slots=True)
class News:
    """Keeps the number of the first frame that tells what the newest frame sent tells, apart from where it is.

    Attributes:
        first: the number of that frame.
        newest: the number of the newest frame.
    """

    first: int = 0
    newest: int = -1
    _standing: _Standing | None = None

    def sent(self, frame: Telemetry) -> None:
        """Take note of a frame that is sent; `first` changes with what it tells."""
        self.newest = frame.frame
        standing = frame.mode, frame.target, len(frame.reached), frame.commands, frame.cause
        if standing != self._standing:
            self.first, self._standing = frame.frame, standing

    def differ(self, executive: Executive) -> bool:
        """Tell whether no frame has told yet how the robot stands."""
        target = -1 if executive.target is None else executive.target.index
        reached = executive.num_reached
        return self._standing != (executive.mode, target, reached, executive.statuses, executive.cause)

    def are_in(self, frame: Telemetry | None) -> bool:
        """Tell whether a frame that has arrived tells how the robot stands now; None for no frame yet."""
        return frame is not None and frame.frame >= self.first
