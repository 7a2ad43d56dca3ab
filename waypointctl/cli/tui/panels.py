"""The parts of the live view beside the map: heading, clocks, commands, happenings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from rich.table import Table
from rich.text import Text

from waypointctl.cli.tui.formatting import Happening, at
from waypointctl.display_text import printable
from waypointctl.log.messages import Clock, Mode, Severity, Telemetry
from waypointctl.replay.legs import WaypointStatus
from waypointctl.replay.summary_builder import FlightSummaryBuilder
from waypointctl.units import seconds

CLOCK_STYLES: Final = {Clock.ROBOT: "green", Clock.OPERATOR: "magenta"}
_SEVERITY_STYLES: Final = {Severity.INFO: "", Severity.WARNING: "yellow", Severity.ERROR: "bold red"}


def heading(title: str, status: str, flight: FlightSummaryBuilder, *, ascii_only: bool) -> Text:
    """Return one line: the mission, how many waypoints are done and known to be, and the status of the view."""
    waypoints = flight.waypoints
    reached = sum(waypoint.status is WaypointStatus.REACHED for waypoint in waypoints)
    known = sum(waypoint.known_ns is not None for waypoint in waypoints)
    line = Text(no_wrap=True, overflow="ellipsis")
    line.append(printable(title), "bold").append("  ")
    if len(waypoints) <= 12:
        full, half, empty = "#=-" if ascii_only else "■◧□"
        line.append(full * known, "magenta").append(half * (reached - known), "green")
        line.append(empty * (len(waypoints) - reached), "dim").append(" ")
    line.append(f"{reached} of {len(waypoints)} reached, {known} known")
    return line.append(f"  {status}", "dim")


def clocks(flight: FlightSummaryBuilder, *, is_known_only: bool = False) -> Table:
    """Return what time it is for the robot, the age of the operator's knowledge, and how the link is.

    With `is_known_only` the time is the operator's: what is true of the robot is not shown.
    """
    table = Table.grid(padding=(0, 1))
    table.add_column(no_wrap=True)
    table.add_column(no_wrap=True, overflow="ellipsis")
    times = [("time", "bold", at(flight.now_ns))] if is_known_only else _robot(flight)
    for label, style, value in (*times, *_operator(flight), *_link(flight)):
        table.add_row(_text(label, style), _text(value))
    return table


def commands(flight: FlightSummaryBuilder, most: int, *, narrow: bool) -> Table:
    """Return the newest commands: their stage on board and as it is known to the operator."""
    table = Table(box=None, padding=(0, 1, 0, 0), expand=True, pad_edge=False, header_style="dim")
    table.add_column("#", no_wrap=True)
    table.add_column("command", no_wrap=True, overflow="ellipsis", ratio=1)
    for name, style in (("issued", "magenta"), ("arrived", "green")):
        if not narrow:
            table.add_column(name, justify="right", no_wrap=True, style=style)
    table.add_column("on board", no_wrap=True, style="green")
    table.add_column("known", no_wrap=True, style="magenta")
    table.add_column("round trip", justify="right", no_wrap=True)
    for command in flight.newest_commands(most):
        times = () if narrow else (at(command.issued_ns), at(command.received_ns))
        onboard = str(command.onboard) if command.onboard else "-"
        row = (
            str(command.id),
            printable(command.description),
            *times,
            onboard,
            str(command.known_stage),
            at(command.round_trip_ns),
        )
        table.add_row(*row)
    return table


def happenings(lines: Sequence[Happening]) -> Text:
    """Return one line for each."""
    text = Text(no_wrap=True, overflow="ellipsis")
    for number, line in enumerate(lines):
        text.append("\n" if number else "")
        text.append(f"{seconds(line.time_ns):9.2f} s ").append(f"{line.clock:<8} ", CLOCK_STYLES[line.clock])
        text.append(line.text, _SEVERITY_STYLES[line.severity])
    return text


Rows = list[tuple[str, str, str]]


def _robot(flight: FlightSummaryBuilder) -> Rows:
    state = flight.state
    if state is None:
        return [("robot", "bold green", at(flight.now_ns))]
    speed = math.hypot(float(state.qvel[0]), float(state.qvel[1]))
    return [
        ("robot", "bold green", at(state.time_ns)),
        ("position", "", f"{_place(float(state.qpos[0]), float(state.qpos[1]))}, {speed:.1f} m/s"),
    ]


def _operator(flight: FlightSummaryBuilder) -> Rows:
    frame = flight.telemetry
    trip_ns = flight.round_trip_ns
    trip = ("round trip", "", "not yet measured" if trip_ns is None else f"{at(trip_ns)}, newest measured")
    if frame is None:
        return [("operator", "bold magenta", "no telemetry yet"), trip]
    return [
        ("operator", "bold magenta", f"telemetry from {at(frame.issued_ns)}"),
        ("age", "", f"{at(flight.now_ns - frame.issued_ns)}{_position_error(flight, frame)}"),
        ("last known", "", f"position {_place(frame.x_m, frame.y_m)}"),
        ("mode", "", _mode(flight, frame)),
        trip,
    ]


def _link(flight: FlightSummaryBuilder) -> Rows:
    """Return how the link is, which neither end knows: contact, and messages not delivered."""
    setting, link, now_ns = flight.setting, flight.link, flight.now_ns
    contacts = {f"link {way}": windows.state_text(now_ns) for way, windows in setting.ways.items() if windows}
    if len(contacts) == 2 and len(set(contacts.values())) == 1:
        contacts = {"link": contacts["link up"]}
    rows = [(label, "bold blue", text) for label, text in contacts.items()]
    missing = {"up": len(link.up.missing_ns), "down": len(link.down.missing_ns)}
    if any(missing.values()):
        text = ", ".join(f"{count} {way}" for way, count in missing.items() if count)
        rows.append(("losses", "red", text))
    if link.lost_since_ns is not None:
        rows.append(("link lost", "bold red", f"on board, at {at(link.lost_since_ns)}"))
    return rows


def _position_error(flight: FlightSummaryBuilder, frame: Telemetry) -> str:
    if flight.state is None:
        return ""
    x_m, y_m = float(flight.state.qpos[0]), float(flight.state.qpos[1])
    return f", error {math.hypot(frame.x_m - x_m, frame.y_m - y_m):.1f} m"


def _mode(flight: FlightSummaryBuilder, frame: Telemetry) -> str:
    names = {waypoint.planned.index: printable(waypoint.planned.name) for waypoint in flight.waypoints}
    if frame.mode is Mode.RETURNING:
        return "returning home"
    if frame.target not in names:
        return str(frame.mode)
    return f"{frame.mode} {'to' if frame.mode is Mode.NAVIGATING else 'at'} {names[frame.target]}"


def _place(x_m: float, y_m: float) -> str:
    return f"({x_m:.1f}, {y_m:.1f})"


def _text(value: str, style: str = "") -> Text:

    return Text(value, style or "")
