"""A console whose lines are typed at times of the simulation."""

from __future__ import annotations

from collections.abc import Iterator

from waypointctl.units import ns


class ScriptedLines:
    """Types each line at its time [s]."""

    is_open = True

    def __init__(self, *lines: tuple[float, str]) -> None:
        self._lines = [(ns(at_s), text) for at_s, text in lines]

    def lines(self, now_ns: int) -> Iterator[str]:
        while self._lines and self._lines[0][0] <= now_ns:
            yield self._lines.pop(0)[1]

    def asleep(self, now_ns: int, until_ns: int) -> int:
        return min([until_ns, *(at_ns for at_ns, _ in self._lines[:1])])
