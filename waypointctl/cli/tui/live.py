"""The live view of a flight: a sink that draws at most ten times a second of wall time."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from waypointctl.cli.tui.chart import draw_map
from waypointctl.cli.tui.formatting import Happening, happening
from waypointctl.cli.tui.map_scene import scene_so_far
from waypointctl.cli.tui.panels import clocks, commands, happenings, heading
from waypointctl.log.setting import MissionSetting
from waypointctl.replay.summary_builder import FlightSummaryBuilder

if TYPE_CHECKING:
    from rich.console import Console, Group, RenderableType
    from rich.rule import Rule

    from waypointctl.log.messages import Message, PlannedWaypoint

PERIOD_S: Final = 0.1  # of wall time between two pictures; the flight itself is never slowed down
_CLOCKS_WIDTH: Final = 34
_CLOCKS_HEIGHT: Final = 7
_WAY_POINTS: Final = 4000  # drawn of the way walked: more would cost time and show nothing
_MOST_HAPPENINGS: Final = 8
_NO_SETTING: Final = MissionSetting()


@dataclass(frozen=True, slots=True)
class Sizes:
    """How much of each part there is room for.

    Attributes:
        side_by_side: map and clocks beside each other, not one above the other.
        map_columns: its width.
        map_lines: its height; 0 for no map.
        commands: how many; 0 for none.
        happenings: how many; 0 for none.
    """

    side_by_side: bool
    map_columns: int
    map_lines: int
    commands: int
    happenings: int


def sizes(width: int, height: int) -> Sizes:
    """Divide a terminal of `width` columns and `height` lines; the last line stays free."""
    lines = height - 2  # the heading, and the line the cursor is on
    shown = min(_MOST_HAPPENINGS, max(0, (lines - _CLOCKS_HEIGHT - 1) // 3))
    known = min(6, max(0, (lines - _CLOCKS_HEIGHT - 5) // 3))
    left = lines - (shown + 1 if shown else 0) - (known + 2 if known else 0)
    if width >= 2 * _CLOCKS_WIDTH:
        columns = width - _CLOCKS_WIDTH - 2
        return Sizes(True, columns, min(left, columns // 2 + 2) if left >= 3 else 0, known, shown)
    stacked = left - _CLOCKS_HEIGHT
    return Sizes(False, width, min(stacked, width // 2 + 2) if stacked >= 4 else 0, known, shown)


class LiveView:
    """Draws the flight whose messages it is given; use it in a `with` block.

    Attributes:
        flight: the flight so far.
    """

    def __init__(
        self,
        people: Console,
        title: str,
        waypoints: Iterable[PlannedWaypoint],
        setting: MissionSetting = _NO_SETTING,
    ) -> None:
        """Draw on `people`, a terminal, under `title`, with what the mission has fixed beforehand."""
        from rich.live import Live

        self._status = ""
        self._waypoints, self._setting = tuple(waypoints), setting
        self._title = title
        self._console = people
        self._ascii_only = not people.encoding.lower().startswith("utf")
        self.restart()
        self._live = Live(console=people, auto_refresh=False, redirect_stdout=False, redirect_stderr=False)

    def __call__(self, message: Message) -> None:
        """Take one message, and draw if it is time to."""
        self.flight(message)
        event = happening(message)
        if event is not None:
            self._happenings.append(event)
        if time.monotonic() >= self._next_s:
            self.draw()

    def __enter__(self) -> Self:
        """Begin to draw."""
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the last picture standing."""
        self.say("")
        self.draw()
        self._live.stop()

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

    def draw(self) -> None:
        """Draw now."""
        self._live.update(self.picture(), refresh=True)
        self._next_s = time.monotonic() + PERIOD_S

    def picture(self) -> Group:
        """Return the whole view, made to the terminal's size as it is now."""
        from rich.console import Group

        width, height = self._console.size
        plan = sizes(width, height)
        parts: list[RenderableType] = [heading(self._title, self._status, self.flight, ascii_only=self._ascii_only)]
        parts += self._upper(plan)
        if plan.commands:
            narrow = width < 2 * _CLOCKS_WIDTH
            parts += [self._rule(), commands(self.flight, plan.commands, narrow=narrow)]
        if plan.happenings:
            newest = list(self._happenings)[-plan.happenings :]
            parts += [self._rule(), happenings(newest)]
        return Group(*parts)

    def _rule(self) -> Rule:
        from rich.rule import Rule

        return Rule(style="dim", characters="-" if self._ascii_only else "─")

    def _upper(self, plan: Sizes) -> list[RenderableType]:
        from rich.console import Group
        from rich.table import Table

        facts = clocks(self.flight)
        if not plan.map_lines:
            return [facts]
        drawing = Group(*self._map(plan))
        if not plan.side_by_side:
            return [facts, drawing]
        table = Table.grid(padding=(0, 2, 0, 0))
        table.add_column(width=plan.map_columns, no_wrap=True)
        table.add_column(width=_CLOCKS_WIDTH)
        table.add_row(drawing, facts)
        return [table]

    def _map(self, plan: Sizes) -> list[RenderableType]:
        scene = scene_so_far(self.flight, _WAY_POINTS)
        return list(draw_map(scene, plan.map_columns, plan.map_lines, ascii_only=self._ascii_only))
