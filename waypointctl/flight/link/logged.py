"""A direction of the link with the log beside it: what it does to a message besides delaying it is written down."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import Any, Final, Generic, TypeVar

from waypointctl.flight.link.direction import NO_CONTACT, NOISE, QUEUE_FULL, Delivery, Direction
from waypointctl.flight.link.frames import size_bytes
from waypointctl.log.messages import Ack, Command, DeliveryOutcome, LinkRecord, Telemetry

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

    def send(self, now_ns: int, make: Callable[[int], T]) -> Delivery:
        """Hand over a message at `now_ns` [ns].

        Args:
            now_ns: when.
            make: maps the time of arrival [ns] to the message; called once more, for its size.
        """
        message = make(now_ns)
        size = size_bytes(message)
        delivery = self.direction.send(now_ns, size, make)
        what = _what(now_ns, delivery)
        if what is not None:
            kind, number = named(message)
            self.sink(LinkRecord(now_ns, self.way, kind, number, size, delivery.departs_ns, delivery.arrivals_ns, what))
        return delivery

    def due(self, now_ns: int) -> Iterator[T]:
        """Take out, one by one, what has arrived by now, in order of arrival."""
        return self.direction.due(now_ns)


def named(message: Any) -> tuple[str, int]:
    """Return what kind of message it is, such as "telemetry", and its number."""
    number = next(getattr(message, name) for name in _NUMBERS if hasattr(message, name))
    return type(message).__name__.lower(), number


def _what(now_ns: int, delivery: Delivery) -> DeliveryOutcome | None:
    """Return what the link did besides delaying a message, if it did."""
    if delivery.lost:
        return _LOST[delivery.lost]
    if len(delivery.arrivals_ns) > 1:
        return DeliveryOutcome.DUPLICATED
    return DeliveryOutcome.QUEUED if delivery.departs_ns > now_ns else None


def link_state(up: Direction[Any], down: Direction[Any]) -> dict[str, object]:
    """Return what later arrivals depend on, as plain data.

    Of telemetry only the frames' numbers, of the first and the last to arrive: over a slow link thousands may be under
    way.
    """
    arriving = [message for _, message in down.under_way]
    frames = [message.frame for message in arriving if isinstance(message, Telemetry)]
    acks = [_plain(message) for message in arriving if isinstance(message, Ack)]
    commands = [_command(message) for _, message in up.under_way if isinstance(message, Command)]
    return {
        "up": {"commands": commands, **up.state()},
        "down": {"acks": acks, "frames": frames[:1] + frames[1:][-1:], **down.state()},
    }


def _command(command: Command) -> dict[str, object]:
    return _plain(command) | {"waypoints": [_plain(waypoint) for waypoint in command.waypoints]}


def _plain(record: Any) -> dict[str, object]:
    """Return a record's fields by name; not copied, as `asdict` does: there may be thousands of records."""
    return {each.name: getattr(record, each.name) for each in fields(record)}
