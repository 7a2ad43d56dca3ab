"""Protobuf messages in which nothing but numbers and times changes: laid out once by protobuf, then packed in one go.

A packed message has the same bytes before and after every number, so it differs from protobuf's own bytes in two
ways that every parser reads alike: a number that is 0 is written out, and a time has always the same length.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from typing import Final

from google.protobuf.message import Message as ProtobufMessage
from google.protobuf.timestamp_pb2 import Timestamp

from waypointctl.units import NS_PER_S

# What stands in a prototype for what is to come. No text has these bytes in it: they are not UTF-8.
NUMBER: Final[float] = struct.unpack("<d", b"\xfe" * 8)[0]
MOMENT: Final = Timestamp(seconds=2**35 - 1, nanos=2**31 - 1)

_NUMBER_BYTES: Final = struct.pack("<d", NUMBER)
_MOMENT_BYTES: Final = MOMENT.SerializeToString()
_PLACE: Final = re.compile(b"(" + re.escape(_NUMBER_BYTES) + b"|" + re.escape(_MOMENT_BYTES) + b")")


class Template:
    """A message of fixed layout."""

    def __init__(self, prototype: ProtobufMessage) -> None:
        """Lay it out as `prototype`, in which NUMBER and MOMENT stand wherever something changes."""
        parts = _PLACE.split(prototype.SerializeToString())  # what stays and what changes, by turns
        formats = ("d" if part == _NUMBER_BYTES else f"{len(part)}s" for part in parts)
        self._struct = struct.Struct("<" + "".join(formats))
        self._parts: list[float | bytes] = [*parts]

    def pack(self, values: Sequence[float | bytes]) -> bytes:
        """Return the message with `values`, numbers and moments in the order of their field numbers.

        Raises:
            ValueError: there are more or fewer of them than places.
        """
        parts = self._parts.copy()
        parts[1::2] = values
        return self._struct.pack(*parts)


def moment(time_ns: int) -> bytes:
    """Return a time from 0 to 2**63 - 1 [ns] as a protobuf timestamp, 12 bytes long."""
    seconds, nanos = divmod(time_ns, NS_PER_S)
    return bytes((0x08, *_varint(seconds), 0x10, *_varint(nanos)))


def _varint(value: int) -> tuple[int, int, int, int, int]:
    # Five times seven bits, the lower first; all but the last are marked as not the last.
    return value & 127 | 128, value >> 7 & 127 | 128, value >> 14 & 127 | 128, value >> 21 & 127 | 128, value >> 28
