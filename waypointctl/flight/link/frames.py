"""What travels the link, how large it is, and the record of what the link does to it besides delaying it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.link.direction import NO_CONTACT, NOISE, QUEUE_FULL, Delivery, Direction
from waypointctl.log.messages import Ack, Command, DeliveryOutcome, LinkRecord, Message, Mode, Telemetry
from waypointctl.log.topics import BY_KIND

FloatArray = NDArray[np.float64]

HEADER_BYTES: Final = 6
MOST_DATA_BYTES: Final = 65_536
NUMBER_BYTES: Final = 8
_DELAY_BYTES: Final = 9  # of the log's delay_s: a tag and a double
_RECEIVED: Final = "received_ns"

# Bytes of a mode's name on the wire where they are not the log's: renaming a mode must not move a frame's arrival.
_MODE_BYTES: Final = {Mode.NAVIGATING: 7, Mode.TELEOPERATED: 7}
T = TypeVar("T")
UP: Final = "up"
DOWN: Final = "down"
_LOST: Final = {
    NOISE: DeliveryOutcome.LOST,
    QUEUE_FULL: DeliveryOutcome.QUEUE_FULL,
    NO_CONTACT: DeliveryOutcome.NO_CONTACT,
}
_NUMBERS: Final = ("command_id", "id", "frame", "step")  # what messages are counted by


@dataclass(frozen=True, slots=True)
class BodyFrame:
    """The state of the robot's body at a control step, on its way down."""

    step: int
    qpos: FloatArray  # (nq,) [m, quaternion w x y z, rad]
    qvel: FloatArray  # (nv,) [m/s, rad/s]
    issued_ns: int
    received_ns: int


@dataclass(frozen=True, slots=True)
class ControlFrame:
    """An action, on its way up."""

    step: int  # whose state it was computed from
    values: FloatArray  # (nu,) the action, each number from -1 to 1
    issued_ns: int
    received_ns: int


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """A sign of life from the ground, on its way up."""

    frame: int
    issued_ns: int
    received_ns: int


def size_bytes(message: Any) -> int:
    """Return the size of a message that travels the link: a record of the log, or another frozen dataclass."""
    return packets_bytes(_logged(message) if isinstance(message, Command | Ack | Telemetry) else _plain(message))


def packets_bytes(data_bytes: int) -> int:
    """Return the size of the space packets that carry this much data."""
    packets = max(1, -(-data_bytes // MOST_DATA_BYTES))
    return packets * HEADER_BYTES + max(data_bytes, 1)


def _logged(message: Command | Ack | Telemetry) -> int:
    # Protobuf leaves out what is 0: with an arrival of 0 only the delay is left, which the sender does not know.
    kind: type[Message] = type(message)
    encoded = len(BY_KIND[kind].encode(replace(message, received_ns=0)))
    if isinstance(message, Telemetry):
        encoded += _MODE_BYTES.get(message.mode, len(message.mode)) - len(message.mode)
    return encoded - _DELAY_BYTES if message.issued_ns else encoded


def _plain(message: Any) -> int:
    values = (getattr(message, field.name) for field in fields(message) if field.name != _RECEIVED)
    return sum(value.nbytes if isinstance(value, np.ndarray) else NUMBER_BYTES for value in values)


@dataclass(slots=True)
class LoggedDirection(Generic[T]):
    """One direction of the link."""

    direction: Direction[T]  # decides what becomes of each message
    way: str  # "up" or "down"
    sink: Callable[[LinkRecord], None]  # takes a record of each message that is lost or doubled, or has to wait

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
    acks = [_fields_of(message) for message in arriving if isinstance(message, Ack)]
    commands = [_command(message) for _, message in up.under_way if isinstance(message, Command)]
    return {
        "up": {"commands": commands, **up.state()},
        "down": {"acks": acks, "frames": frames[:1] + frames[1:][-1:], **down.state()},
    }


def _command(command: Command) -> dict[str, object]:
    return _fields_of(command) | {"waypoints": [_fields_of(waypoint) for waypoint in command.waypoints]}


def _fields_of(record: Any) -> dict[str, object]:
    """Return a record's fields by name; not copied, as `asdict` does: there may be thousands of records."""
    return {each.name: getattr(record, each.name) for each in fields(record)}
