"""The tables of flights: waypoints, commands and reward of one; outcomes of many."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

from waypointctl.cli.tui.formatting import number
from waypointctl.cli.tui.grid_view import GridView
from waypointctl.display_text import printable
from waypointctl.evaluation.grid import Column, Grid
from waypointctl.replay.summary import WaypointStatus
from waypointctl.units import seconds

if TYPE_CHECKING:
    from rich.table import Table

    from waypointctl.cli.run_many import Outcome
    from waypointctl.replay.command_summary import CommandSummary
    from waypointctl.replay.summary import FlightSummary, WaypointSummary

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
    Column("known stage", is_text=True),
)
_SENT: Final = Column("sent", spare=8)
_REWARD: Final = (Column("reward", is_text=True), Column("sum"), Column("a step", spare=1))


def waypoint_table(summary: FlightSummary) -> GridView:
    """Return the waypoints: when the robot reached each, and when the operator learned of it."""
    rows = tuple(_waypoint_row(waypoint) for waypoint in summary.waypoints)
    missed = tuple(place for place, one in enumerate(summary.waypoints) if one.status is not WaypointStatus.REACHED)
    return GridView(Grid("", _WAYPOINTS, rows), (), striking=missed)


def command_table(summary: FlightSummary) -> GridView:
    """Return the commands: issued, received, acknowledged, ended, end known; delays and round trip.

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


def flights_table(outcomes: Iterable[Outcome]) -> Table:
    """Return a row for each mission file: its flight's outcome, waypoints, time and log."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold", show_edge=False)
    table.add_column("mission", overflow="fold")
    table.add_column("outcome", no_wrap=True)
    table.add_column("reached", justify="right", no_wrap=True)
    table.add_column("time [s]", justify="right", no_wrap=True)
    table.add_column("log", overflow="fold")
    for outcome in outcomes:
        table.add_row(*_row(outcome), style=_style(outcome))
    return table


def _row(outcome: Outcome) -> tuple[str, ...]:
    if outcome.result is None:
        return printable(outcome.path), "broken" if outcome.problem else "not flown", "-", "-", "-"
    result = outcome.result
    reached = f"{result.waypoints_reached}/{result.waypoints_total}"
    flown = f"{seconds(result.sim_time_ns):.2f}"
    return printable(outcome.mission), result.outcome, reached, flown, printable(result.log or "-")


def _style(outcome: Outcome) -> str | None:
    if outcome.result is None:
        return "red"
    return None if outcome.result.outcome == "success" else "yellow"
