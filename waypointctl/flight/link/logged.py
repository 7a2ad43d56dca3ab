"""A direction of the link with the log beside it: what it does to a message besides delaying it is written down."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar

from waypointctl.flight.link.direction import NO_CONTACT, NOISE, QUEUE_FULL, Direction, Fate
from waypointctl.flight.link.size import size_bytes
from waypointctl.log.messages import DeliveryOutcome, LinkRecord

T = TypeVar("T")

UP: Final = "up"
DOWN: Final = "down"

_LOST: Final = {
    NOISE: DeliveryOutcome.LOST,
    QUEUE_FULL: DeliveryOutcome.QUEUE_FULL,
    NO_CONTACT: DeliveryOutcome.NO_CONTACT,
}
_NUMBERS: Final = ("command_id", "id", "frame", "step")  # what messages are counted by


@dataclass(slots=True)
class LoggedDirection(Generic[T]):
    """One direction of the link.

    Attributes:
        direction: decides what becomes of each message.
        way: "up" or "down".
        sink: takes a record of each message that is lost or doubled, or has to wait.
    """

    direction: Direction[T]
    way: str
    sink: Callable[[LinkRecord], None]

    def send(self, now_ns: int, make: Callable[[int], T]) -> Fate:
        """Hand over a message at `now_ns` [ns].

        Args:
            now_ns: when.
            make: returns the message, told when it arrives [ns]; asked once more, for its size.
        """
        message = make(now_ns)
        size = size_bytes(message)
        fate = self.direction.send(now_ns, size, make)
        what = _what(now_ns, fate)
        if what is not None:
            kind, number = named(message)
            self.sink(LinkRecord(now_ns, self.way, kind, number, size, fate.departs_ns, fate.arrivals_ns, what))
        return fate

    def due(self, now_ns: int) -> Iterator[T]:
        """Take out, one by one, what has arrived by now, in order of arrival."""
        return self.direction.due(now_ns)


def named(message: Any) -> tuple[str, int]:
    """Return what kind of message it is, such as "telemetry", and its number."""
    number = next(getattr(message, name) for name in _NUMBERS if hasattr(message, name))
    return type(message).__name__.lower(), number


def _what(now_ns: int, fate: Fate) -> DeliveryOutcome | None:
    """Return what the link did besides delaying a message, if it did."""
    if fate.lost:
        return _LOST[fate.lost]
    if len(fate.arrivals_ns) > 1:
        return DeliveryOutcome.DOUBLED
    return DeliveryOutcome.WAITED if fate.departs_ns > now_ns else None
