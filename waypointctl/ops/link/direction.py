"""One direction of the link: what becomes of each message, decided when it is handed over.

A message waits in the queue until those before it have left and a contact is open, is sent at the link's rate, may be
lost or doubled on the way, and arrives after the light time and what the network adds. All of it follows from what
was sent before and from named random streams, so a message costs the same work whether it is under way for a
millisecond or for days.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final, Generic, NamedTuple, TypeVar

import numpy as np

from waypointctl.ops.link.contacts import Contacts, airtime_ns
from waypointctl.ops.link.delay import Delay, Jitter, fixed_delay
from waypointctl.ops.link.loss import GilbertElliott, Loss

T = TypeVar("T")

# Why a message never arrives.
QUEUE_FULL: Final = "queue full"
NO_CONTACT: Final = "no contact"
NOISE: Final = "lost on the way"
NEVER: Final = -1


class Fate(NamedTuple):
    """What becomes of a message.

    Attributes:
        departs_ns: when its first bit leaves; NEVER if it does not.
        left_ns: when its last bit has left; NEVER if it does not.
        arrivals_ns: when it arrives: once, or twice where the link doubles it, or not at all.
        lost: why it does not arrive; empty if it does.
    """

    departs_ns: int
    left_ns: int
    arrivals_ns: tuple[int, ...]
    lost: str


@dataclass(slots=True)
class Direction(Generic[T]):
    """One direction of the link, and what is under way in it.

    Attributes:
        delay: one-way delay [ns] of a message that left at a time [ns].
        jitter: what is added to it, drawn for each message that arrives; a message never arrives before it has left.
        keeps_order: whether nothing overtakes what was sent before it.
        loss: whether a message is lost.
        doubled: the probability that a message is doubled; of the two one may be lost.
        doubling: where that comes from.
        rate_bps: in [bit/s]; 0 is without limit.
        queue_bytes: how much can wait to be sent; a message that does not fit in any more is lost.
        contacts: when the link can be used; None for always.
    """

    delay: Delay = fixed_delay(0)
    jitter: Jitter | None = None
    keeps_order: bool = True
    loss: Loss | None = None
    doubled: float = 0.0
    doubling: np.random.Generator | None = None
    rate_bps: float = 0.0
    queue_bytes: int = 1 << 20
    contacts: Contacts | None = None
    streams: dict[str, np.random.Generator] = field(default_factory=dict)  # all that it draws from, for its state
    _under_way: list[tuple[int, int, T]] = field(default_factory=list)  # a heap: (arrival, number, message)
    _waiting: deque[tuple[int, int]] = field(default_factory=deque)  # (departure, bytes)
    _waiting_bytes: int = 0
    _free_ns: int = 0  # when the last message's last bit has left
    _last_arrival_ns: int = 0
    _number: int = 0

    def send(self, now_ns: int, size_bytes: int, make: Callable[[int], T]) -> Fate:
        """Hand over a message; `make` is told a time of arrival [ns] and returns what arrives then."""
        placed = self._place(now_ns, size_bytes)
        if placed is None:
            return Fate(NEVER, NEVER, (), QUEUE_FULL if self._full(size_bytes) else NO_CONTACT)
        departs, left, delay = placed
        copies = 1
        if self.doubling is not None and self.doubling.random() < self.doubled:
            copies = 2
        if self.loss is not None and self.loss():
            copies -= 1
        if not copies:
            return Fate(departs, left, (), NOISE)
        if copies == 1:
            return Fate(departs, left, (self._deliver(left, delay, make),), "")
        return Fate(departs, left, (self._deliver(left, delay, make), self._deliver(left, delay, make)), "")

    def due(self, now_ns: int) -> Iterator[T]:
        """Take out, one by one, what has arrived by now, in order of arrival."""
        under_way = self._under_way
        while under_way and under_way[0][0] <= now_ns:
            yield heapq.heappop(under_way)[2]

    @property
    def under_way(self) -> list[T]:
        """What was sent and has not arrived, in order of arrival."""
        return [message for _, _, message in sorted(self._under_way, key=lambda entry: entry[:2])]

    def waiting_bytes(self, now_ns: int) -> int:
        """Return how much waits in the queue."""
        waiting = self._waiting
        while waiting and waiting[0][0] <= now_ns:
            self._waiting_bytes -= waiting.popleft()[1]
        return self._waiting_bytes

    def state(self) -> dict[str, object]:
        """Return what becomes of the next message depends on, as plain data."""
        return {
            "free_ns": self._free_ns,
            "last_arrival_ns": self._last_arrival_ns,
            "waiting": [list(entry) for entry in self._waiting],
            "bad": self.loss.bad if isinstance(self.loss, GilbertElliott) else False,
            "random": {name: rng.bit_generator.state for name, rng in self.streams.items()},
        }

    def _place(self, now_ns: int, size_bytes: int) -> tuple[int, int, int | None] | None:
        """Return when a message leaves, first and last bit [ns], and its contact's own light time; None for never."""
        departs = self._free_ns if self._free_ns > now_ns else now_ns
        delay_ns: int | None = None
        if self.contacts is None:
            left = departs + airtime_ns(8 * size_bytes, self.rate_bps)
        else:
            placed = self.contacts.place(departs, 8 * size_bytes, self.rate_bps)
            if placed is None:
                return None
            departs, left, window = placed
            delay_ns = window.delay_ns
        if departs > now_ns:
            if self.waiting_bytes(now_ns) + size_bytes > self.queue_bytes:
                return None
            self._waiting.append((departs, size_bytes))
            self._waiting_bytes += size_bytes
        self._free_ns = left
        return departs, left, delay_ns

    def _full(self, size_bytes: int) -> bool:
        return self._waiting_bytes + size_bytes > self.queue_bytes

    def _deliver(self, left_ns: int, delay_ns: int | None, make: Callable[[int], T]) -> int:
        arrives = left_ns + (self.delay(left_ns) if delay_ns is None else delay_ns)
        if self.jitter is not None:
            arrives = max(arrives + self.jitter(), left_ns)
        if self.keeps_order:
            if arrives < self._last_arrival_ns:
                arrives = self._last_arrival_ns
            self._last_arrival_ns = arrives
        self._number += 1
        heapq.heappush(self._under_way, (arrives, self._number, make(arrives)))
        return arrives
