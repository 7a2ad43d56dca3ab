"""One direction of the link: what becomes of each message, decided when it is handed over.

A message waits in the queue until those before it have left and a contact is open, is sent at the link's rate, may be
lost or doubled on the way, and arrives after the light time and what the network adds. All of it follows from what
was sent before and from named random streams, so a message costs the same work whether it is under way for a
millisecond or for days.

Each message takes the same numbers from each stream, whatever becomes of it: the fate of one shifts no other's luck.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final, Generic, NamedTuple, TypeVar

from waypointctl.flight.link.contacts import Contacts, always
from waypointctl.flight.link.impairments import Delay, Draws, Jitter, Loss

T = TypeVar("T")

# Why a message never arrives.
QUEUE_FULL: Final = "queue full"
NO_CONTACT: Final = "no contact"
NOISE: Final = "lost on the way"
NEVER: Final = -1
DEFAULT_QUEUE_BYTES: Final = 1 << 20


class Delivery(NamedTuple):
    """What becomes of a message."""

    departs_ns: int  # when its first bit leaves; NEVER if it does not
    left_ns: int  # when its last bit has left; NEVER if it does not
    arrivals_ns: tuple[int, ...]  # when it arrives, in order: once, or twice where the link doubles it, or not at all
    lost: str  # why it does not arrive; empty if it does


_NO_CONTACT: Final = Delivery(NEVER, NEVER, (), NO_CONTACT)
_QUEUE_FULL: Final = Delivery(NEVER, NEVER, (), QUEUE_FULL)


def _no_delay(_: int) -> int:
    return 0


@dataclass(frozen=True, slots=True)
class Duplication:
    """Messages that arrive twice. As in netem, one that is to be doubled and to be lost arrives once.

    Attributes:
        choose: returns whether the next message is duplicated.
        jitter: of the second one; None where the link has no jitter.
    """

    choose: Loss  # a choice with a probability, as losing is
    jitter: Jitter | None = None


@dataclass(slots=True)
class Direction(Generic[T]):
    """One direction of the link, and what is under way in it."""

    delay: Delay = _no_delay  # one-way delay [ns] of a message whose last bit left at a time [ns]
    jitter: Jitter | None = None  # what is added to it; a message still never arrives before it has left
    keeps_order: bool = True  # whether nothing overtakes what was sent before it
    loss: Loss | None = None  # whether a message is lost on the way
    duplication: Duplication | None = None  # whether a message arrives twice
    contacts: Contacts = field(default_factory=always)  # when and how fast something can be sent
    # How much can wait for it. A message that has to wait and does not fit is lost; the one that is being sent
    # does not wait, so a message larger than the queue goes when it need not wait
    queue_bytes: int = DEFAULT_QUEUE_BYTES
    _under_way: list[tuple[int, int, T]] = field(default_factory=list, init=False)  # a heap: (arrival, number, message)
    _waiting: deque[tuple[int, int]] = field(default_factory=deque, init=False)  # (departure, bytes), in order
    _waiting_bytes: int = field(default=0, init=False)
    _free_ns: int = field(default=0, init=False)  # when the last bit of all that was accepted has left
    _last_arrival_ns: int = field(default=0, init=False)
    _number: int = field(default=0, init=False)

    def send(self, now_ns: int, size_bytes: int, make: Callable[[int], T]) -> Delivery:
        """Hand over a message, not before any that was handed over already.

        Args:
            now_ns: when.
            size_bytes: its size, at least 1.
            make: maps a time of arrival [ns] to what arrives then.
        """
        jitter_ns = 0 if self.jitter is None else self.jitter.draws()
        copies = 1 if self.loss is None or not self.loss() else 0
        second_ns = 0
        if self.duplication is not None:
            copies += self.duplication.choose()
            second_ns = 0 if self.duplication.jitter is None else self.duplication.jitter.draws()
        placed = self.contacts.place(self._free_ns if self._free_ns > now_ns else now_ns, size_bytes)
        if placed is None:
            return _NO_CONTACT
        departs_ns, left_ns = placed
        if departs_ns > now_ns and not self._waits(now_ns, departs_ns, size_bytes):
            return _QUEUE_FULL
        self._free_ns = left_ns
        if not copies:
            return Delivery(departs_ns, left_ns, (), NOISE)
        arrives_ns = self._deliver(left_ns, jitter_ns, make)
        if copies == 1:
            return Delivery(departs_ns, left_ns, (arrives_ns,), "")
        other_ns = self._deliver(left_ns, second_ns, make)
        return Delivery(departs_ns, left_ns, (min(arrives_ns, other_ns), max(arrives_ns, other_ns)), "")

    def due(self, now_ns: int) -> Iterator[T]:
        """Take out, one by one, what has arrived by now, in order of arrival."""
        under_way = self._under_way
        while under_way and under_way[0][0] <= now_ns:
            yield heapq.heappop(under_way)[2]

    def latest_arrival_ns(self, now_ns: int, size_bytes: int) -> int | None:
        """Return when a message handed over now arrives at the latest [ns], unless it is lost; None for never.

        What a sender can know: it counts its own queue, the windows and rates, the delay, and as much jitter as all but
        one in thirty thousand messages have.
        """
        placed = self.contacts.place(max(self._free_ns, now_ns), size_bytes)
        if placed is None:
            return None
        _, left_ns = placed
        most_ns = 0 if self.jitter is None else max(self.jitter.most_ns, 0)
        arrives_ns = left_ns + self.delay(left_ns) + most_ns
        return max(arrives_ns, self._last_arrival_ns) if self.keeps_order else arrives_ns

    def is_dead(self, now_ns: int) -> bool:
        """Return whether nothing that is handed over now or later arrives: no contact is left, or all of it is lost."""
        if self.loss is not None and self.loss.loses_all and self.duplication is None:
            return True
        return self.contacts.place(max(self._free_ns, now_ns), 1) is None

    @property
    def next_arrival_ns(self) -> int | None:
        """When the next message arrives [ns]; None where nothing is under way."""
        return self._under_way[0][0] if self._under_way else None

    @property
    def under_way(self) -> list[tuple[int, T]]:
        """What was handed over, is not lost and has not arrived: (arrival [ns], message), in order of arrival."""
        return [(arrives_ns, message) for arrives_ns, _, message in sorted(self._under_way, key=_order)]

    def waiting_bytes(self, now_ns: int) -> int:
        """Return how much waits in the queue."""
        waiting = self._waiting
        while waiting and waiting[0][0] <= now_ns:
            self._waiting_bytes -= waiting.popleft()[1]
        return self._waiting_bytes

    def state(self) -> dict[str, Any]:
        """Return all that what becomes of later messages depends on, as plain data; what is under way is not in it."""
        return {
            "free_ns": self._free_ns,
            "last_arrival_ns": self._last_arrival_ns,
            "waiting": [list(entry) for entry in self._waiting],
            "random": {name: each.state() for name, each in self._draws().items()},
        }

    def _draws(self) -> dict[str, Loss | Draws[int]]:
        """Return all that draws random numbers, by name."""
        draws: dict[str, Loss | Draws[int]] = {}
        if self.jitter is not None:
            draws["jitter"] = self.jitter.draws
        if self.loss is not None:
            draws["loss"] = self.loss
        if self.duplication is not None:
            draws["doubling"] = self.duplication.choose
            if self.duplication.jitter is not None:
                draws["second"] = self.duplication.jitter.draws
        return draws

    def _waits(self, now_ns: int, departs_ns: int, size_bytes: int) -> bool:
        """Queue a message until it departs; return whether there was room."""
        if self.waiting_bytes(now_ns) + size_bytes > self.queue_bytes:
            return False
        self._waiting.append((departs_ns, size_bytes))
        self._waiting_bytes += size_bytes
        return True

    def _deliver(self, left_ns: int, jitter_ns: int, make: Callable[[int], T]) -> int:
        arrives_ns = left_ns + self.delay(left_ns) + jitter_ns
        if arrives_ns < left_ns:
            arrives_ns = left_ns
        if self.keeps_order:
            if arrives_ns < self._last_arrival_ns:
                arrives_ns = self._last_arrival_ns
            self._last_arrival_ns = arrives_ns
        self._number += 1
        heapq.heappush(self._under_way, (arrives_ns, self._number, make(arrives_ns)))
        return arrives_ns


def _order(entry: tuple[int, int, Any]) -> tuple[int, int]:
    return entry[:2]
