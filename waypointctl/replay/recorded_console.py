"""What was done by hand in a flight, for flying it again: the lines typed at its console, and its interruption."""

from __future__ import annotations

from collections.abc import Iterator

from waypointctl.flight.operator.console import QUIT, request_from
from waypointctl.log.messages import ConsoleInput
from waypointctl.mission.mission import Mission
from waypointctl.replay.comparator import LogComparator
from waypointctl.replay.summary import FlightSummary


class RecordedConsole:
    """The console of a flight that is flown again: each line comes when it came.

    Attributes:
        is_open: whether the flight had one.
        has_closed: whether it was closed by now.
    """

    def __init__(self, comparator: LogComparator, mission: Mission, events: FlightSummary) -> None:
        """Take the lines from the log that `comparator` reads; `events` is the summary of its events."""
        self.is_open = events.had_console
        self.has_closed = False
        self._comparator = comparator
        self._mission = mission
        self._interrupted_ns = events.interrupted_ns
        self._now_ns = -1

    def lines(self, now_ns: int) -> Iterator[str]:
        """Yield the lines that were typed at this moment."""
        self._now_ns = now_ns
        while (line := self._upcoming) is not None and line.time_ns == now_ns:
            self.has_closed = self.has_closed or line.text == QUIT
            yield self._understood(line.text)

    def asleep(self, now_ns: int, until_ns: int) -> int:
        """Return when the next line comes, or the flight is interrupted, if that is before `until_ns`."""
        line = self._upcoming
        return min(until_ns, self._interrupted_ns, until_ns if line is None else line.time_ns)

    def interrupted(self) -> bool:
        """Tell whether the flight was interrupted by now."""
        return self._now_ns >= self._interrupted_ns

    @property
    def _upcoming(self) -> ConsoleInput | None:
        if self._comparator.upcoming_kind is not ConsoleInput:
            return None
        upcoming = self._comparator.upcoming
        return upcoming if isinstance(upcoming, ConsoleInput) else None

    def _understood(self, text: str) -> str:
        if text != QUIT:
            try:
                request_from(text, self._mission)
            except ValueError as error:
                raise self._comparator.diverged("/console", "text", repr(text), f"not understood: {error}") from error
        return text
