"""Times, sizes and event lines as text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from waypointctl.display_text import printable
from waypointctl.log.messages import Ack, Clock, Event, Message, Severity, Stage
from waypointctl.units import seconds

# Acknowledgements that are listed; RECEIVED and ACCEPTED come just before STARTED.
_TELLING: Final = (Stage.STARTED, Stage.COMPLETED, Stage.FAILED, Stage.REJECTED)


@dataclass(frozen=True, slots=True)
class Happening:
    """A line of the flight's event list, and the clock that its time is on."""

    time_ns: int
    clock: Clock
    severity: Severity
    text: str

    @property
    def line(self) -> str:
        """One line: the time, whose clock it is on, and what happened."""
        return f"{seconds(self.time_ns):10.3f} s  {self.clock:<8}  {self.text}"


def happening(message: Message) -> Happening | None:
    """Return the line for a message, None for most messages."""
    match message:
        case Event():
            return Happening(message.time_ns, message.clock, message.severity, printable(message.text))
        case Ack() if message.stage in _TELLING:
            severity = Severity.ERROR if message.stage in (Stage.FAILED, Stage.REJECTED) else Severity.INFO
            why = f" ({printable(message.reason)})" if message.reason else ""
            age_s = seconds(message.received_ns - message.issued_ns)
            text = f"ack received: command {message.command_id} {message.stage}{why}, {age_s:.3f} s ago"
            return Happening(message.received_ns, Clock.OPERATOR, severity, text)
        case _:
            return None


def at(time_ns: int | None) -> str:
    """Return a time, or a dash for one that never came."""
    return "-" if time_ns is None else f"{seconds(time_ns):.2f} s"


def number(time_ns: int | None) -> str:
    """Return a time without its unit, or a dash for one that never came."""
    return "-" if time_ns is None else f"{seconds(time_ns):.2f}"


def size(count: int) -> str:
    """Return a number of bytes."""
    number = float(count)
    for unit in ("B", "kB", "MB"):
        if number < 1000:
            return f"{count} B" if unit == "B" else f"{number:.1f} {unit}"
        number /= 1000
    return f"{number:.1f} GB"
