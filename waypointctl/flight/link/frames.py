"""What travels the link beside commands, acknowledgements and telemetry."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.messages import Ack, Command, Message, Mode, Telemetry
from waypointctl.log.topics import BY_KIND

FloatArray = NDArray[np.float64]


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


HEADER_BYTES: Final = 6
MOST_DATA_BYTES: Final = 65_536
NUMBER_BYTES: Final = 8

_DELAY_BYTES: Final = 9  # of the log's delay_s: a tag and a double
_RECEIVED: Final = "received_ns"

# Bytes of a mode's name on the wire where they are not the log's: renaming a mode must not move a frame's arrival.
_MODE_BYTES: Final = {Mode.NAVIGATING: 7, Mode.TELEOPERATED: 7}


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
