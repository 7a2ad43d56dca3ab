"""Times, sizes, links, events, and what the operator knows, as text."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from waypointctl.display_text import printable
from waypointctl.log.messages import Ack, Clock, Event, Message, Severity, Stage, Telemetry
from waypointctl.units import RATE_UNITS_BPS, seconds

if TYPE_CHECKING:
    from waypointctl.mission.link import Link, LinkDirection
    from waypointctl.replay.command_summary import CommandSummary
    from waypointctl.replay.summary_builder import OperatorView


_MOST_NAME: Final = 24  # cells of a name
MESSAGE_KINDS: Final = {
    "ack": "acknowledgement",
    "telemetry": "telemetry frame",
    "bodyframe": "state",
    "controlframe": "action",
}
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


def shortened(name: str) -> str:
    """Return a name fit to show, with its end left out where it is long."""
    from rich.cells import cell_len, set_cell_size

    shown = printable(name)
    return shown if cell_len(shown) <= _MOST_NAME else f"{set_cell_size(shown, _MOST_NAME - 3).rstrip()}..."


def size(count: int) -> str:
    """Return a number of bytes."""
    number = float(count)
    for unit in ("B", "kB", "MB"):
        if number < 1000:
            return f"{count} B" if unit == "B" else f"{number:.1f} {unit}"
        number /= 1000
    return f"{number:.1f} GB"


def status_lines(view: OperatorView, now_ns: int) -> list[str]:
    """Return what is known at a time on the operator's clock [ns]: a line for the robot, one for each command."""
    return [_robot(view.flight.telemetry, now_ns), *(_command(command, now_ns) for command in view.flight.commands)]


def command_rows(view: OperatorView, now_ns: int, most: int) -> list[tuple[str, str, str, str]]:
    """Return of each of the newest commands: its id, what it is, the known stage, and how long ago that was."""
    return [
        (str(command.id), printable(command.description), *_stage(command, now_ns, decimals=1))
        for command in view.flight.newest_commands(most)
    ]


def _stage(command: CommandSummary, now_ns: int, decimals: int) -> tuple[str, str]:
    """Return the newest stage that the operator knows of a command, and how long ago that was."""
    report = command.report
    since_ns = command.issued_ns if report is None else report.time_ns
    ago = f"{max(0.0, seconds(now_ns - since_ns)):.{decimals}f} s"
    if report is None:
        return "no report yet", ago
    return f"{report.stage} ({printable(report.reason)})" if report.reason else str(report.stage), ago


def _command(command: CommandSummary, now_ns: int) -> str:
    stage, ago = _stage(command, now_ns, decimals=2)
    return f"command {command.id} {printable(command.description)}: {stage} {ago} ago"


def _robot(frame: Telemetry | None, now_ns: int) -> str:
    if frame is None:
        return "robot: no telemetry received yet"
    target = "" if frame.target < 0 else f" (waypoint {frame.target + 1})"
    reached = ", ".join(str(index + 1) for index in frame.reached) or "none"
    heading_deg = round(math.degrees(frame.heading_rad))  # a whole number has no -0
    return (
        f"robot, {seconds(now_ns - frame.issued_ns):.2f} s ago: at ({frame.x_m:.2f}, {frame.y_m:.2f}) m, heading "
        f"{heading_deg} deg, {frame.speed_mps:.2f} m/s, {frame.mode}{target}; waypoints reached: {reached}"
    )


def link_text(link: Link) -> str:
    """Return what a link does to messages, in a few words."""
    name = f"link {link.preset}:" if link.preset else "link"
    up, down = _way_text(link.up), _way_text(link.down)
    if up != down:
        return f"{name} {up} up, {down} down"
    return f"{name} without delay" if up == "0 s" else f"{name} {up} each way"


def _way_text(way: LinkDirection) -> str:
    return " with ".join(filter(None, (_delay_text(way), " and ".join(_besides(way)))))


def _delay_text(way: LinkDirection) -> str:
    if way.delay_table is not None:
        delays_s = [row.delay_s for row in way.delay_table]
        text = f"{min(delays_s):g} to {max(delays_s):g} s"
    elif way.contact_plan is not None and not way.has_own_delay:
        text = f"the delays and contacts of {way.contact_plan.file}"
    else:
        text = f"{way.delay_s:g} s"
    if way.jitter_file is not None:
        return f"{text} + {way.jitter_file}"
    normal = " (normal)" if way.jitter_distribution == "normal" else ""
    return f"{text} +- {way.jitter_s:g} s{normal}" if way.jitter_s else text


def _besides(way: LinkDirection) -> Iterator[str]:
    """Yield what a way does besides delaying."""
    loss = way.loss if isinstance(way.loss, float) else way.loss.share
    if loss:
        yield f"{100 * loss:.3g} % lost{'' if isinstance(way.loss, float) else ' in bursts'}"
    if way.duplicate:
        yield f"{100 * way.duplicate:.3g} % duplicated"
    if not way.keep_order:
        yield "reordering"
    if way.rate_bps is not None:
        yield rate_text(way.rate_bps)
    if way.windows is not None:
        every = "" if way.windows_period_s is None else f" every {way.windows_period_s:g} s"
        yield f"{len(way.windows)} window{'s' if len(way.windows) > 1 else ''}{every}"
    if way.contact_plan is not None and way.has_own_delay:
        yield f"the contacts of {way.contact_plan.file}"


def rate_text(rate_bps: float) -> str:
    """Return a rate [bit/s] in the largest unit of which it has one: 9.6 kbit/s."""
    unit, size = max((pair for pair in RATE_UNITS_BPS.items() if pair[1] <= max(rate_bps, 1.0)), key=lambda it: it[1])
    return f"{rate_bps / size:.6g} {unit}"
