"""What a log's events say of the flight as a whole: whether it had a console, how and when it ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from waypointctl.log.messages import Event, EventKind
from waypointctl.log.reader import Log

NEVER_NS: Final = 1 << 62


@dataclass(frozen=True, slots=True)
class Milestones:
    """What was announced of a flight.

    Attributes:
        had_console: whether a person could command too.
        ending: how it ended, such as "success: ..."; empty where the log has no end.
        ended_ns: when, on the operator's clock; NEVER_NS where the log has no end.
    """

    had_console: bool
    ending: str
    ended_ns: int

    @property
    def interrupted_ns(self) -> int:
        """When somebody ended it; NEVER_NS for a flight that nobody ended."""
        return self.ended_ns if self.ending.startswith("interrupted") else NEVER_NS


def milestones_of(log: Log) -> Milestones:
    """Read a log's events for them."""
    had_console, ending, ended_ns = False, "", NEVER_NS
    for message in log.messages(("/event",)):
        if not isinstance(message, Event):
            continue
        if message.kind is EventKind.CONSOLE_OPENED:
            had_console = True
        elif message.kind is EventKind.MISSION_ENDED:
            ending, ended_ns = message.text, message.time_ns
    return Milestones(had_console, ending, ended_ns)
