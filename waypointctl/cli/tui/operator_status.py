"""What the operator knows of the robot and of each command, in lines: nothing that has not arrived."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from waypointctl.display_text import printable
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.log.messages import Telemetry
    from waypointctl.replay.command_summary import CommandSummary
    from waypointctl.replay.operator_view import OperatorView


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
