"""The story's tables: waypoints, commands, reward, effort."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.cli.view.words import at, number, printable
from waypointctl.log.messages import EventKind
from waypointctl.replay.story import FARTHEST_M, Fate

if TYPE_CHECKING:
    from rich.table import Table

    from waypointctl.replay.story import CommandStory, Story, WaypointStory


_NAMES: Final = ("waypoint", "command", "reward")  # wrapped where there is little room; numbers are not
_DELAYS_WIDTH: Final = 100  # columns, from which on there is room for the delay of each way
_MOST_REWARD: Final = 1e9  # written out; an altered log's can have 300 digits


def waypoint_table(story: Story) -> Table:
    """Return the waypoints: when the robot reached each, and when the operator learned of it."""
    table = _table("waypoint", "position [m]", "acceptance")
    _add_numbers(table, "set out", "reached", "known", "delay [s]")
    for waypoint in story.waypoints:
        table.add_row(*_waypoint_row(waypoint), style=None if waypoint.fate is Fate.REACHED else "yellow")
    return table


def command_table(story: Story, width: int) -> Table:
    """Return the commands: issued, received, acknowledged, ended, its end heard of; delays and round trip.

    The delay of each way is left out where `width` columns are too few; the times say it too.
    """
    delays = ("up", "down") if width >= _DELAYS_WIDTH else ()
    table = _table("#", "command")
    _add_numbers(table, "issued", "received", "acked", "ended", "heard", *delays, "RTT [s]")
    table.add_column("known as", no_wrap=True)
    for command in story.commands:
        ways = (command.uplink_ns, command.downlink_ns) if delays else ()
        table.add_row(*_command_row(command, ways))
    return table


def reward_table(story: Story) -> Table:
    """Return each reward term's sum and its part in each step."""
    table = _table("reward")
    _add_numbers(table, "sum", "a step")
    for name, total in (*story.reward, ("total", story.reward_total)):
        table.add_row(printable(name), *_reward_row(total, story.steps))
    return table


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


def _table(*headings: str) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold", show_edge=False)
    for heading in headings:
        table.add_column(heading, no_wrap=heading not in _NAMES, overflow="fold")
    return table


def _add_numbers(table: Table, *headings: str) -> None:
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)


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


def _command_row(command: CommandStory, ways: tuple[int | None, ...]) -> tuple[str, ...]:
    times = (command.issued_ns, command.received_ns, command.acknowledged_ns, command.ended_ns, command.concluded_ns)
    numbers = map(number, (*times, *ways, command.round_trip_ns))
    return (str(command.id), printable(command.what), *numbers, str(command.heard))
