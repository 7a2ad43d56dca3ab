"""The tables of flights: waypoints, commands and reward of one; outcomes of many."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from rich import box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderableType
from rich.table import Table
from rich.text import Text

from waypointctl.cli.tui.formatting import number
from waypointctl.evaluation.grid import Column, Grid
from waypointctl.replay.command_summary import CommandSummary
from waypointctl.replay.legs import WaypointStatus, WaypointSummary
from waypointctl.replay.summary import FlightSummary
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.cli.run_many import Outcome

_STRIKING: Final = "yellow"
GAP: Final = 2  # columns of the terminal between two of the table
_NARROWEST: Final = 6  # of a text where there is no room otherwise
_LONG_WORD: Final = 24  # up to this, or a third of the terminal, a word is never broken
_NO_BREAK: Final = "\N{NO-BREAK SPACE}"
_INNER_SPACE: Final = re.compile(r" (?=[^(]*\))")  # of a point: "(7, 12)" is one word


@dataclass(frozen=True, slots=True)
class GridView:
    """A table to print, its title above it and its notes below.

    Where the terminal is too narrow whole columns are left out, and a line names them.
    """

    grid: Grid  # the table
    options: tuple[str, ...] = ("--json",)  # that show all columns, or files that have them, for that line
    ruled: tuple[int, ...] = ()  # rows with a line below them, by index
    striking: tuple[int, ...] = ()  # rows that are to be seen first, by index

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Give rich what there is to print."""
        grid = self.grid.printable()
        widths = fitted_widths(grid, options.max_width)
        left_out = [column.called for index, column in enumerate(grid.columns) if index not in widths]
        if grid.title:
            yield Text(grid.title, style="table.title")
        yield self._table(grid, widths)
        if left_out:
            yield Text(_left_out(left_out, self.options), style="dim")
        yield from (Text(note, style="table.caption") for note in grid.notes)

    def _table(self, grid: Grid, widths: Mapping[int, int]) -> Table:

        table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), show_edge=False)
        for index, width in widths.items():
            column = grid.columns[index]
            heading = "\n".join(broken(column.heading, width))
            side: Literal["left", "right"] = "left" if column.is_text else "right"
            table.add_column(heading, justify=side, width=width, no_wrap=not column.is_text, overflow="fold")
        for place, row in enumerate(grid.rows):
            cells = ("\n".join(broken(row[index], width)) for index, width in widths.items())
            style = _STRIKING if place in self.striking else None
            table.add_row(*cells, style=style, end_section=place in self.ruled)
        return table


def _left_out(headings: Sequence[str], options: Sequence[str]) -> str:
    named = ", ".join(f"'{heading}'" if "," in heading else heading for heading in headings)
    *others, last = ("a wider terminal", *options)
    shown_by = f"{', '.join(others)} or {last}" if others else last
    return f"left out: {named}; {shown_by} shows {'it' if len(headings) == 1 else 'them'}"


def fitted_widths(grid: Grid, width: int) -> dict[int, int]:
    """Return the widths of the columns, by index, that a terminal of `width` columns has room for.

    Text is broken into two lines first, between words; then whole columns are left out, so that no number is ever
    cut. Only where nothing is left to leave out do texts take more lines.
    """
    longest = max(_LONG_WORD, width // 3)
    widths = {index: _least(column, _cells(grid, index), longest) for index, column in enumerate(grid.columns)}
    for index in sorted(widths, key=lambda index: -grid.columns[index].spare):
        if _room(widths, width) >= 0 or not grid.columns[index].spare:
            break
        del widths[index]
    for index in reversed(widths):
        if grid.columns[index].is_text:
            widths[index] -= min(max(0, -_room(widths, width)), max(0, widths[index] - _NARROWEST))
    for index in widths:  # what is left goes to those that need it, from left to right
        whole = max(map(cell_len, (grid.columns[index].heading, *_cells(grid, index))))
        widths[index] += max(0, min(whole - widths[index], _room(widths, width)))
    return widths


def broken(text: str, width: int) -> list[str]:
    """Return a text as lines, broken between words and after hyphens."""
    return [line.replace(_NO_BREAK, " ") for line in textwrap.wrap(_INNER_SPACE.sub(_NO_BREAK, text), width)]


def _least(column: Column, cells: Sequence[str], longest: int) -> int:
    """Return the width from which on a column can be read well; at most `longest` for a text."""
    if column.is_text:
        return max(_two_lines(text, longest) for text in (column.heading, *cells))
    return max(_two_lines(column.heading, longest), *map(cell_len, cells), 1)


def _two_lines(text: str, longest: int) -> int:
    """Return the width at which a text takes two lines without a broken word, or `longest` if that is more."""
    wide = cell_len(text)
    if wide > 2 * longest:
        return longest
    word = max(1, *map(cell_len, _INNER_SPACE.sub(_NO_BREAK, text).split(" ")))
    enough = (width for width in range(min(word, longest), longest) if len(broken(text, width)) <= 2)
    return next(enough, max(1, min(longest, wide)))


def _cells(grid: Grid, index: int) -> list[str]:
    return [row[index] for row in grid.rows]


def _room(widths: Mapping[int, int], width: int) -> int:
    """Return how much of a terminal's width columns of these widths leave; negative where they do not fit."""
    return width - sum(widths.values()) - GAP * (len(widths) - 1)


_MOST_REWARD: Final = 1e9  # written out; an altered log's can have 300 digits
_WAYPOINTS: Final = (
    Column("waypoint", is_text=True),
    Column("position [m]", is_text=True, spare=3),
    Column("acceptance", is_text=True, spare=4),
    Column("leg start", spare=2),
    Column("reached"),
    Column("reported"),
    Column("delay [s]", spare=1),
)
_COMMANDS: Final = (
    Column("#"),
    Column("command", is_text=True),
    Column("issued", spare=2),
    Column("received", spare=4),
    Column("acked", spare=5),
    Column("ended", spare=1),
    Column("end reported", spare=3),
    Column("up", spare=7),
    Column("down", spare=6),
    Column("RTT [s]"),
    Column("reported stage", is_text=True),
)
_SENT: Final = Column("sent", spare=8)
_FLIGHTS: Final = (
    Column("mission", is_text=True),
    Column("outcome", is_text=True),
    Column("reached"),
    Column("time [s]"),
    Column("log", is_text=True),
)
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
    rows = tuple((name, *_reward_row(total, summary.steps)) for name, total in terms)
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
        plan.name,
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
    return (str(command.id), command.description, *map(number, (*times, *ways)), str(command.known_stage))


def flights_table(outcomes: Sequence[Outcome]) -> GridView:
    """Return a row for each mission file: its flight's outcome, waypoints, time and log."""
    failed = tuple(place for place, outcome in enumerate(outcomes) if outcome.verdict != "success")
    return GridView(Grid("", _FLIGHTS, tuple(map(_flight_row, outcomes))), (), striking=failed)


def _flight_row(outcome: Outcome) -> tuple[str, ...]:
    result = outcome.result
    if result is None:
        return str(outcome.path), outcome.word, "-", "-", "-"
    reached = f"{result.waypoints_reached}/{result.waypoints_total}"
    return outcome.mission, result.outcome, reached, f"{seconds(result.sim_time_ns):.2f}", str(result.log or "-")
