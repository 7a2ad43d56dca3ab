"""The screens of a flight: the live view, and the console around a person's line; at most ten pictures a second.

At the console events scroll by above. Only what the ground knows is shown there, and the way on the map is where
telemetry has seen the robot.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Final

from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from waypointctl.cli.tui.chart import Scene, draw_map, scene_so_far
from waypointctl.cli.tui.formatting import Happening, command_rows, happening
from waypointctl.cli.tui.panels import clocks, commands, happenings, heading
from waypointctl.cli.tui.terminal import Screen
from waypointctl.log.header import MissionSetting
from waypointctl.log.messages import Message, PlannedWaypoint
from waypointctl.replay.summary_builder import FlightSummaryBuilder, OperatorView

PERIOD_S: Final = 0.1  # of wall time between two pictures; the flight itself is never slowed down
SIGN: Final = "> "
_CLOCKS_WIDTH: Final = 34
_CLOCKS_HEIGHT: Final = 7
_WAY_POINTS: Final = 4000  # drawn of the path driven: more would cost time and show nothing
_MOST_HAPPENINGS: Final = 8
_MOST_COMMANDS: Final = 5  # at the console
_LEAST_MAP_COLUMNS: Final = 22
_LEAST_MAP_LINES: Final = 4
_NO_SETTING: Final = MissionSetting()


@dataclass(frozen=True, slots=True)
class Sizes:
    """How much of each part a terminal has room for."""

    map_columns: int  # the map's width
    map_lines: int  # its height; 0 for no map
    side_by_side: bool  # map and clocks beside each other
    commands: int  # how many; 0 for none
    happenings: int = 0  # how many; 0 for none


def sizes(width: int, height: int) -> Sizes:
    """Divide a terminal of `width` columns and `height` lines for the live view; the last line stays free."""
    lines = height - 2  # the heading, and the line the cursor is on
    shown = min(_MOST_HAPPENINGS, max(0, (lines - _CLOCKS_HEIGHT - 1) // 3))
    known = min(6, max(0, (lines - _CLOCKS_HEIGHT - 5) // 3))
    left = lines - (shown + 1 if shown else 0) - (known + 2 if known else 0)
    if width >= 2 * _CLOCKS_WIDTH:
        columns = width - _CLOCKS_WIDTH - 2
        return Sizes(columns, min(left, columns // 2 + 2) if left >= 3 else 0, True, known, shown)
    stacked = left - _CLOCKS_HEIGHT
    return Sizes(width, min(stacked, width // 2 + 2) if stacked >= 4 else 0, False, known, shown)


def console_sizes(width: int, height: int) -> Sizes:
    """Divide a terminal of `width` columns and `height` lines for the console; events scroll through what is left."""
    lines = height - max(4, height // 4) - 2  # what scrolls; heading and prompt
    count = min(_MOST_COMMANDS, max(1, (lines - 10) // 2)) if lines >= 5 else 0
    left = lines - (count + 2 if count else 0) - 1  # their heading and the rules
    if left < _LEAST_MAP_LINES:
        return Sizes(0, 0, False, count)
    columns = width - _CLOCKS_WIDTH - 2
    has_clocks = columns >= _LEAST_MAP_COLUMNS
    columns = columns if has_clocks else width
    return Sizes(columns, min(left, columns // 2 + 2), has_clocks, count)


def _map(scene: Scene, plan: Sizes, *, ascii_only: bool) -> Group:

    return Group(*draw_map(scene, plan.map_columns, plan.map_lines, ascii_only=ascii_only))


def _beside(drawing: RenderableType, columns: int, facts: RenderableType) -> Table:

    table = Table.grid(padding=(0, 2, 0, 0))
    table.add_column(width=columns, no_wrap=True)
    table.add_column(width=_CLOCKS_WIDTH)
    table.add_row(drawing, facts)
    return table


class LiveView(Screen):
    """Draws the flight whose messages it is given.

    Attributes:
        flight: the flight so far.
    """

    def __init__(
        self, people: Console, title: str, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting = _NO_SETTING
    ) -> None:
        """Draw on `people`, a terminal, under `title`, with what the mission has fixed beforehand."""
        super().__init__(people, PERIOD_S)
        self._status, self._title = "", title
        self._waypoints, self._setting = tuple(waypoints), setting
        self.restart()

    def __call__(self, message: Message) -> None:
        """Take one message, and draw if it is time to."""
        self.flight(message)
        event = happening(message)
        if event is not None:
            self._happenings.append(event)
        self.draw_if_due()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the last picture standing, without a status."""
        self._status = ""
        super().__exit__(kind, error, traceback)

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""
        self.flight = FlightSummaryBuilder(self._waypoints, self._setting)
        self._happenings = deque[Happening](maxlen=_MOST_HAPPENINGS)
        self._next_s = 0.0

    def say(self, status: str) -> None:
        """Put a word about the view itself beside the title."""
        if status != self._status:
            self._status = status
            self.draw()

    def picture(self) -> Group:
        """Return the whole view, made to the terminal's size as it is now."""
        width, height = self._console.size
        plan = sizes(width, height)
        parts: list[RenderableType] = [heading(self._title, self._status, self.flight, ascii_only=self._ascii_only)]
        facts: RenderableType = clocks(self.flight)
        if plan.map_lines:
            drawing = _map(scene_so_far(self.flight, _WAY_POINTS), plan, ascii_only=self._ascii_only)
            parts += [_beside(drawing, plan.map_columns, facts)] if plan.side_by_side else [facts, drawing]
        else:
            parts.append(facts)
        if plan.commands:
            narrow = width < 2 * _CLOCKS_WIDTH
            parts += [self.rule(), commands(self.flight, plan.commands, narrow=narrow)]
        if plan.happenings:
            parts += [self.rule(), happenings(list(self._happenings)[-plan.happenings :])]
        return Group(*parts)


class ConsoleScreen(Screen):
    """Draws what the ground knows of a flight around a person's line."""

    def __init__(
        self, people: Console, title: str, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting
    ) -> None:
        """Draw on `people`, a terminal, under `title`, with what the mission has fixed beforehand."""
        super().__init__(people, PERIOD_S)
        self._title, self._waypoints, self._setting = title, tuple(waypoints), setting
        self.prompt = SIGN
        self.restart()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the last picture standing, without a prompt."""
        self.prompt = ""
        super().__exit__(kind, error, traceback)

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""
        self.view = OperatorView(self._waypoints, self._setting)
        self._next_s = 0.0

    def __call__(self, message: Message) -> None:
        """Take one message."""
        self.view(message)

    def say(self, text: str) -> None:
        """Print lines above the picture, broken between words where they are too long."""
        self._console.print(Text(text))

    def picture(self) -> Group:
        """Return all that stays in sight, made to the terminal's size as it is now."""
        width, height = self._console.size
        plan, flight = console_sizes(width, height), self.view.flight
        parts: list[RenderableType] = [heading(self._title, "", flight, ascii_only=self._ascii_only)]
        if plan.map_lines:
            seen = replace(scene_so_far(flight, _WAY_POINTS), truth=flight.belief(_WAY_POINTS), belief=None)
            drawing = _map(seen, plan, ascii_only=self._ascii_only)
            facts = clocks(flight, is_known_only=True)
            parts.append(_beside(drawing, plan.map_columns, facts) if plan.side_by_side else drawing)
        if plan.commands:
            parts += [self.rule(), self._commands(plan.commands)]
        if plan.map_lines:
            parts.append(self.rule())
        return Group(*parts, self._prompt(width))

    def _commands(self, most: int) -> Table:

        table = Table(box=None, padding=(0, 1, 0, 0), expand=True, pad_edge=False, header_style="dim")
        table.add_column("#", no_wrap=True)
        table.add_column("command", no_wrap=True, overflow="ellipsis", ratio=1)
        table.add_column("known", no_wrap=True, overflow="ellipsis", style="magenta")
        table.add_column("ago", justify="right", no_wrap=True)
        for row in command_rows(self.view, self.view.now_ns, most):
            table.add_row(*row)
        return table

    def _prompt(self, width: int) -> Text:
        """Return the line being typed, its end in sight."""
        line = Text(self.prompt[-max(1, width - 2) :], no_wrap=True, overflow="crop")
        return line.append(" ", "reverse") if self.prompt else line
