"""Watching a flight: the live view on a terminal, a line for each event elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Protocol, Self

from waypointctl.cli.console import console, is_live
from waypointctl.cli.tui.formatting import happening
from waypointctl.log.messages import Message, PlannedWaypoint
from waypointctl.log.setting import MissionSetting
from waypointctl.replay.summary_builder import FlightSummaryBuilder


class Watch(AbstractContextManager["Watch"], Protocol):
    """A sink that shows people the flight whose messages it is given."""

    flight: FlightSummaryBuilder

    def __call__(self, message: Message) -> None:
        """Take one message."""

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""

    def say(self, status: str) -> None:
        """Put a word about the view itself beside what it shows, where there is room for one."""


def watch(title: str, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting) -> Watch:
    """Return what shows a flight on stderr, under its title and with what its mission has fixed beforehand."""
    people = console(stderr=True)
    if not is_live(people):
        return PlainLines(waypoints, setting)
    from waypointctl.cli.tui.live import LiveView

    return LiveView(people, title, waypoints, setting)


class PlainLines:
    """Writes one line to stderr for each happening.

    Attributes:
        flight: the flight so far.
    """

    def __init__(self, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting) -> None:
        """Begin with the waypoints of the mission, and what else it has fixed beforehand."""
        self._waypoints, self._setting = tuple(waypoints), setting
        self.restart()

    def __call__(self, message: Message) -> None:
        """Take one message."""
        self.flight(message)
        event = happening(message)
        if event is not None:
            print(event.line, file=sys.stderr, flush=True)

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave what has been written."""

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""
        self.flight = FlightSummaryBuilder(self._waypoints, self._setting)

    def say(self, status: str) -> None:
        """Say nothing: among the lines of a flight it would be out of place."""
