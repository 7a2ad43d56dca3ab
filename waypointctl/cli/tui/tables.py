"""The story's tables: waypoints, commands, reward, effort."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.cli.tui.formatting import at, number
from waypointctl.cli.tui.grid_view import GridView
from waypointctl.display_text import printable
from waypointctl.evaluation.grid import Column, Grid
from waypointctl.log.messages import EventKind
from waypointctl.replay.story import Fate
from waypointctl.replay.track import FARTHEST_M

if TYPE_CHECKING:
    from waypointctl.replay.story import CommandStory, Story, WaypointStory


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
    Column("heard", spare=3),
    Column("up", spare=7),
    Column("down", spare=6),
    Column("RTT [s]"),
    Column("known as", is_text=True),
)
_SENT: Final = Column("sent", spare=8)
_REWARD: Final = (Column("reward", is_text=True), Column("sum"), Column("a step", spare=1))


def waypoint_table(story: Story) -> GridView:
    """Return the waypoints: when the robot reached each, and when the operator learned of it."""
    rows = tuple(_waypoint_row(waypoint) for waypoint in story.waypoints)
    missed = tuple(place for place, one in enumerate(story.waypoints) if one.fate is not Fate.REACHED)
    return GridView(Grid("", _WAYPOINTS, rows), (), striking=missed)


def command_table(story: Story) -> GridView:
    """Return the commands: issued, received, acknowledged, ended, its end heard of; delays and round trip.

    How often each was sent, and lost, has a column where one was sent more than once.
    """
    rows = tuple(_command_row(command) for command in story.commands)
    if all(command.attempts < 2 and not command.losses for command in story.commands):
        return GridView(Grid("", _COMMANDS, rows), ())
    sent = [f"{command.attempts}, {command.losses} lost" for command in story.commands]
    columns = (*_COMMANDS[:2], _SENT, *_COMMANDS[2:])
    return GridView(Grid("", columns, tuple((*row[:2], n, *row[2:]) for row, n in zip(rows, sent, strict=True))), ())


def reward_table(story: Story) -> GridView:
    """Return each reward term's sum and its part in each step."""
    terms = (*story.reward, ("total", story.reward_total))
    rows = tuple((printable(name), *_reward_row(total, story.steps)) for name, total in terms)
    return GridView(Grid("", _REWARD, rows), ())


def _reward_row(total: float, steps: int) -> tuple[str, str]:
    if abs(total) > _MOST_REWARD:
        return f"{total:.3g}", f"{total / steps:+.3g}" if steps else "-"
    return f"{total:,.2f}", f"{total / steps:+.4f}" if steps else "-"


def effort_lines(story: Story) -> list[str]:
    """Return how far, how fast, and how the time was spent."""
    effort = story.effort
    speed = "" if effort.mean_speed_mps is None else f", {effort.mean_speed_mps:.2f} m/s while walking"
    spent = f"{effort.walking_ns / 1e9:.2f} s walking, {effort.standing_ns / 1e9:.2f} s standing"
    if effort.standing_share is not None:
        spent += f" ({effort.standing_share:.0%})"
    if effort.fallen_ns:
        spent += f", {effort.fallen_ns / 1e9:.2f} s fallen"
    lines = [f"distance   {effort.distance_m:.2f} m{speed}", f"time       {spent}"]
    if story.falls:
        falls = (at(event.time_ns) for event in story.events if event.kind is EventKind.FALL)
        lines.append(f"fell       at {', '.join(falls)}")
    if off_map := _off_map(story):
        lines.append(f"left out   {off_map}: not finite, or beyond {FARTHEST_M:,.0f} m")
    return lines


def _off_map(story: Story) -> str:
    """Return how much of the log no map or sum can take in, in words; nothing of a log that was not altered."""
    waypoints = sum(not waypoint.is_on_map for waypoint in story.waypoints)
    counts = ((story.states_off_map, "state"), (story.frames_off_map, "telemetry frame"), (waypoints, "waypoint"))
    return ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for count, what in counts if count)


def _waypoint_row(waypoint: WaypointStory) -> tuple[str, ...]:
    plan = waypoint.planned
    learned, reached = waypoint.learned_ns, waypoint.reached_ns
    delay = None if learned is None or reached is None else learned - reached
    return (
        printable(plan.name),
        f"({plan.x_m:g}, {plan.y_m:g})",
        f"{plan.acceptance} {plan.tolerance_m:g} m",
        number(waypoint.started_ns),
        str(waypoint.fate) if reached is None else number(reached),
        number(learned),
        number(delay),
    )


def _command_row(command: CommandStory) -> tuple[str, ...]:
    times = (command.issued_ns, command.received_ns, command.acknowledged_ns, command.ended_ns, command.concluded_ns)
    ways = (command.uplink_ns, command.downlink_ns, command.round_trip_ns)
    return (str(command.id), printable(command.what), *map(number, (*times, *ways)), str(command.heard))
