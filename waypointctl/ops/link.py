"""The link between operator and robot, one direction: what is sent arrives later, in the order it was sent."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

import numpy as np


class Carried(Protocol):
    """A message that knows when it arrives."""

    @property
    def received_ns(self) -> int:
        """When it arrives [ns]."""


T = TypeVar("T", bound=Carried)


@dataclass(slots=True)
class Link(Generic[T]):
    """One direction of the link.

    Attributes:
        delay_ns: one-way delay.
        jitter_ns: the delay varies evenly by up to this, up and down.
        rng: where the jitter comes from.
        in_transit: sent and not yet due, in order of arrival.
        last_arrival_ns: nothing overtakes what was sent before it.
    """

    delay_ns: int
    jitter_ns: int
    rng: np.random.Generator
    in_transit: deque[T] = field(default_factory=deque)
    last_arrival_ns: int = 0

    def send(self, issued_ns: int, make: Callable[[int], T]) -> T:
        """Put a message on its way; `make` is told its time of arrival [ns] and returns it."""
        jitter = int(self.rng.integers(-self.jitter_ns, self.jitter_ns, endpoint=True)) if self.jitter_ns else 0
        self.last_arrival_ns = max(self.last_arrival_ns, issued_ns + self.delay_ns + jitter)
        message = make(self.last_arrival_ns)
        self.in_transit.append(message)
        return message

    def state(self) -> dict[str, object]:
        """Return what the next arrival depends on, as plain data."""
        return {"last_arrival_ns": self.last_arrival_ns, "random": self.rng.bit_generator.state}

    def due(self, now_ns: int) -> Iterator[T]:
        """Take out, one by one, what has arrived by now."""
        while self.in_transit and self.in_transit[0].received_ns <= now_ns:
            yield self.in_transit.popleft()
