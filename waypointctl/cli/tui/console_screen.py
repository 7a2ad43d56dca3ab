"""The console on a terminal: events scroll by above; map, commands and the line being typed stay below it.

Only what the ground knows is shown. The way on the map is where telemetry has seen the robot.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from waypointctl.cli.tui.chart import draw_map
from waypointctl.cli.tui.map_scene import scene_so_far
from waypointctl.cli.tui.operator_status import command_rows
from waypointctl.cli.tui.panels import clocks, heading
from waypointctl.log.messages import Message, PlannedWaypoint
from waypointctl.log.setting import MissionSetting
from waypointctl.replay.operator_view import OperatorView

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table
    from rich.text import Text

PERIOD_S: Final = 0.1  # of wall time between two pictures
SIGN: Final = "> "
_FACTS_COLUMNS: Final = 34
_LEAST_MAP_COLUMNS: Final = 22
_LEAST_MAP_LINES: Final = 4
_MOST_COMMANDS: Final = 5
_WAY_POINTS: Final = 4000


@dataclass(frozen=True, slots=True)
class Layout:
    """How the lines of a terminal are divided; events scroll through the lines that are left.

    Attributes:
        map_columns: the map's width; 0 for no map.
        map_lines: its height.
        facts: whether there is room for times and places beside the map, or in its place.
        commands: how many; 0 for none.
    """

    map_columns: int
    map_lines: int
    facts: bool
    commands: int


def layout(width: int, height: int) -> Layout:
    """Divide a terminal of `width` columns and `height` lines."""
    lines = height - max(4, height // 4) - 2  # what scrolls; heading and prompt
    count = min(_MOST_COMMANDS, max(1, (lines - 10) // 2)) if lines >= 5 else 0
    left = lines - (count + 2 if count else 0) - 1  # their heading and the rules
    if left < _LEAST_MAP_LINES:
        return Layout(0, 0, False, count)
    map_columns = width - _FACTS_COLUMNS - 2
    has_facts = map_columns >= _LEAST_MAP_COLUMNS
    columns = map_columns if has_facts else width
    return Layout(columns, min(left, columns // 2 + 2), has_facts, count)


class ConsoleScreen:
    """Draws what the ground knows of a flight around a person's line; use it in a `with` block."""

    def __init__(
        self, people: Console, title: str, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting
    ) -> None:
        """Draw on `people`, a terminal, under `title`, with what the mission has fixed beforehand."""
        from rich.live import Live

        self._console, self._title = people, title
        self._waypoints, self._setting = tuple(waypoints), setting
        self._ascii_only = not people.encoding.lower().startswith("utf")
        self._live = Live(console=people, auto_refresh=False, redirect_stdout=False, redirect_stderr=False)
        self.prompt = SIGN
        self.restart()

    def __enter__(self) -> Self:
        """Begin to draw."""
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the last picture standing, without a prompt."""
        self.prompt = ""
        self.draw(self.view.now_ns)
        self._live.stop()

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""
        self.view = OperatorView(self._waypoints, self._setting)
        self._next_s = 0.0

    def __call__(self, message: Message) -> None:
        """Take one message."""
        self.view(message)

    def say(self, text: str) -> None:
        """Print lines above the picture, broken between words where they are too long."""
        from rich.text import Text

        self._console.print(Text(text))

    def draw_if_due(self, now_ns: int) -> None:
        """Draw what is known at a time on the operator's clock [ns], if it is time for another picture."""
        if time.monotonic() >= self._next_s:
            self.draw(now_ns)

    def draw(self, now_ns: int) -> None:
        """Draw what is known at a time on the operator's clock [ns]."""
        self.view.pass_time(now_ns)
        self._live.update(self.picture(), refresh=True)
        self._next_s = time.monotonic() + PERIOD_S

    def picture(self) -> RenderableType:
        """Return all that stays in sight, made to the terminal's size as it is now."""
        from rich.console import Group

        width, height = self._console.size
        plan = layout(width, height)
        flight = self.view.flight
        parts: list[RenderableType] = [heading(self._title, "", flight, ascii_only=self._ascii_only)]
        if plan.map_lines:
            parts.append(self._upper(plan))
        if plan.commands:
            parts += [self._rule(), self._commands(plan.commands)]
        if plan.map_lines:
            parts.append(self._rule())
        parts.append(self._prompt(width))
        return Group(*parts)

    def _upper(self, plan: Layout) -> RenderableType:
        from rich.console import Group
        from rich.table import Table

        scene = scene_so_far(self.view.flight, _WAY_POINTS)
        seen = replace(scene, truth=self.view.flight.belief(_WAY_POINTS), belief=None)
        drawing = Group(*draw_map(seen, plan.map_columns, plan.map_lines, ascii_only=self._ascii_only))
        if not plan.facts:
            return drawing
        table = Table.grid(padding=(0, 2, 0, 0))
        table.add_column(width=plan.map_columns, no_wrap=True)
        table.add_column(width=_FACTS_COLUMNS)
        table.add_row(drawing, clocks(self.view.flight, is_known_only=True))
        return table

    def _commands(self, most: int) -> Table:
        from rich.table import Table

        table = Table(box=None, padding=(0, 1, 0, 0), expand=True, pad_edge=False, header_style="dim")
        table.add_column("#", no_wrap=True)
        table.add_column("command", no_wrap=True, overflow="ellipsis", ratio=1)
        table.add_column("known", no_wrap=True, overflow="ellipsis", style="magenta")
        table.add_column("ago", justify="right", no_wrap=True)
        for row in command_rows(self.view, self.view.now_ns, most):
            table.add_row(*row)
        return table

    def _rule(self) -> RenderableType:
        from rich.rule import Rule

        return Rule(style="dim", characters="-" if self._ascii_only else "─")

    def _prompt(self, width: int) -> Text:
        """Return the line being typed, its end in sight."""
        from rich.text import Text

        room = max(1, width - 2)
        line = Text(self.prompt[-room:] if len(self.prompt) > room else self.prompt, no_wrap=True, overflow="crop")
        return line.append(" ", "reverse") if self.prompt else line
