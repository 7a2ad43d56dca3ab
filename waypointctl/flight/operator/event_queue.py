"""What the operator has decided and not yet sent, during its think time."""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(slots=True)
class EventQueue(Generic[T]):
    """Things to do at a time, in the order of their times, and as they were noted where those are the same."""

    _entries: list[tuple[int, int, T]] = field(default_factory=list)  # a heap: (time, number, what)
    _noted: int = 0

    @property
    def next_ns(self) -> int | None:
        """When the first is due [ns]; None where there is none."""
        return self._entries[0][0] if self._entries else None

    def add(self, at_ns: int, what: T) -> None:
        """Note something to do."""
        self._noted += 1
        heapq.heappush(self._entries, (at_ns, self._noted, what))

    def due(self, now_ns: int) -> list[T]:
        """Take out what is due by now."""
        taken = []
        while self._entries and self._entries[0][0] <= now_ns:
            taken.append(heapq.heappop(self._entries)[2])
        return taken

    def clear(self) -> None:
        """Forget everything."""
        self._entries.clear()

    def entries(self) -> list[tuple[int, T]]:
        """Return what is noted, in order."""
        return [(at_ns, what) for at_ns, _, what in sorted(self._entries, key=lambda entry: entry[:2])]
