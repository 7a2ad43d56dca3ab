"""The summary's tables: waypoints, commands, reward, effort."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.cli.tui.formatting import at, number
from waypointctl.cli.tui.grid_view import GridView
from waypointctl.display_text import printable
from waypointctl.evaluation.grid import Column, Grid
from waypointctl.log.messages import EventKind
from waypointctl.replay.summary import WaypointStatus
from waypointctl.replay.track import FARTHEST_M

if TYPE_CHECKING:
    from waypointctl.replay.summary import CommandSummary, FlightSummary, WaypointSummary


_MOST_REWARD: Final = 1e9  # written out; an altered log's can have 300 digits
_WAYPOINTS: Final = (
    Column("waypoint", is_text=True),
    Column("position [m]", is_text=True, spare=3),
    Column("acceptance", is_text=True, spare=4),
    Column("set out", spare=2),
    Column("reached"),
    Column("known"),
    Column("delay [s]", spare=1),
)
_COMMANDS: Final = (
    Column("#"),
    Column("command", is_text=True),
    Column("issued", spare=2),
    Column("received", spare=4),
    Column("acked", spare=5),
    Column("ended", spare=1),
    Column("end known", spare=3),
    Column("up", spare=7),
    Column("down", spare=6),
    Column("RTT [s]"),
    Column("known as", is_text=True),
)
_SENT: Final = Column("sent", spare=8)
_REWARD: Final = (Column("reward", is_text=True), Column("sum"), Column("a step", spare=1))


def waypoint_table(summary: FlightSummary) -> GridView:
    """Return the waypoints: when the robot reached each, and when the operator learned of it."""
    rows = tuple(_waypoint_row(waypoint) for waypoint in summary.waypoints)
    missed = tuple(place for place, one in enumerate(summary.waypoints) if one.status is not WaypointStatus.REACHED)
    return GridView(Grid("", _WAYPOINTS, rows), (), striking=missed)


def command_table(summary: FlightSummary) -> GridView:
    """Return the commands: issued, received, acknowledged, ended, its end heard of; delays and round trip.

    How often each was sent, and lost, has a column where one was sent more than once.
    """
    rows = tuple(_command_row(command) for command in summary.commands)
    if all(command.attempts < 2 and not command.losses for command in summary.commands):
        return GridView(Grid("", _COMMANDS, rows), ())
    sent = [f"{command.attempts}, {command.losses} lost" for command in summary.commands]
    columns = (*_COMMANDS[:2], _SENT, *_COMMANDS[2:])
    return GridView(Grid("", columns, tuple((*row[:2], n, *row[2:]) for row, n in zip(rows, sent, strict=True))), ())


def reward_table(summary: FlightSummary) -> GridView:
    """Return each reward term's sum and its part in each step."""
    terms = (*summary.reward, ("total", summary.reward_total))
    rows = tuple((printable(name), *_reward_row(total, summary.steps)) for name, total in terms)
    return GridView(Grid("", _REWARD, rows), ())


def _reward_row(total: float, steps: int) -> tuple[str, str]:
    if abs(total) > _MOST_REWARD:
        return f"{total:.3g}", f"{total / steps:+.3g}" if steps else "-"
    return f"{total:,.2f}", f"{total / steps:+.4f}" if steps else "-"


def effort_lines(summary: FlightSummary) -> list[str]:
    """Return how far, how fast, and how the time was spent."""
    effort = summary.effort
    speed = "" if effort.mean_speed_mps is None else f", {effort.mean_speed_mps:.2f} m/s while walking"
    spent = f"{effort.walking_ns / 1e9:.2f} s walking, {effort.standing_ns / 1e9:.2f} s standing"
    if effort.standing_share is not None:
        spent += f" ({effort.standing_share:.0%})"
    if effort.fallen_ns:
        spent += f", {effort.fallen_ns / 1e9:.2f} s fallen"
    lines = [f"distance   {effort.distance_m:.2f} m{speed}", f"time       {spent}"]
    if summary.falls:
        falls = (at(event.time_ns) for event in summary.events if event.kind is EventKind.FALL)
        lines.append(f"fell       at {', '.join(falls)}")
    if off_map := _off_map(summary):
        lines.append(f"left out   {off_map}: not finite, or beyond {FARTHEST_M:,.0f} m")
    return lines


def _off_map(summary: FlightSummary) -> str:
    """Return how much of the log no map or sum can take in, in words; nothing of a log that was not altered."""
    waypoints = sum(not waypoint.is_on_map for waypoint in summary.waypoints)
    counts = ((summary.states_off_map, "state"), (summary.frames_off_map, "telemetry frame"), (waypoints, "waypoint"))
    return ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for count, what in counts if count)


def _waypoint_row(waypoint: WaypointSummary) -> tuple[str, ...]:
    plan = waypoint.planned
    learned, reached = waypoint.known_ns, waypoint.reached_ns
    delay = None if learned is None or reached is None else learned - reached
    return (
        printable(plan.name),
        f"({plan.x_m:g}, {plan.y_m:g})",
        f"{plan.acceptance} {plan.tolerance_m:g} m",
        number(waypoint.started_ns),
        str(waypoint.status) if reached is None else number(reached),
        number(learned),
        number(delay),
    )


def _command_row(command: CommandSummary) -> tuple[str, ...]:
    times = (command.issued_ns, command.received_ns, command.acknowledged_ns, command.ended_ns, command.end_known_ns)
    ways = (command.uplink_ns, command.downlink_ns, command.round_trip_ns)
    return (str(command.id), printable(command.description), *map(number, (*times, *ways)), str(command.known_stage))
