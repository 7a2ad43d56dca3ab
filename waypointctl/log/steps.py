"""The messages of every control step to protobuf bytes, put together from pieces: the hot part of topics.py.

Protobuf concatenates: the bytes of a message are the bytes of its fields, one after the other. Arrays are the bulk of
these messages and stand in memory as protobuf writes them, so protobuf encodes only what is around them, once.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from functools import lru_cache
from typing import Final

from google.protobuf.message import Message as ProtobufMessage
from google.protobuf.timestamp_pb2 import Timestamp

from waypointctl.log.messages import Action, FloatArray, Observation, Reward, State
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.units import NS_PER_S

_LENGTH_DELIMITED: Final = 2  # protobuf's wire type of a packed array


def state(message: State) -> bytes:
    """Encode a State."""
    return (
        _step(message.time_ns, message.step)
        + doubles(pb.State.QPOS_FIELD_NUMBER, message.qpos)
        + doubles(pb.State.QVEL_FIELD_NUMBER, message.qvel)
        + doubles(pb.State.QACC_WARMSTART_FIELD_NUMBER, message.qacc_warmstart)
    )


def observation(message: Observation) -> bytes:
    """Encode an Observation."""
    return _step(message.time_ns, message.step) + doubles(pb.Observation.VALUES_FIELD_NUMBER, message.values)


def action(message: Action) -> bytes:
    """Encode an Action."""
    return (
        _step(message.time_ns, message.step)
        + _source(message.source)
        + doubles(pb.Action.COMMANDED_FIELD_NUMBER, message.commanded)
        + doubles(pb.Action.APPLIED_FIELD_NUMBER, message.applied)
    )


def reward(message: Reward) -> bytes:
    """Encode a Reward."""
    names, values = zip(*message.terms, strict=True) if message.terms else ((), ())
    return _step(message.time_ns, message.step) + _terms(names).pack((*values, message.total))


def doubles(field: int, values: FloatArray) -> bytes:
    """Encode an array (n,) as the packed repeated double field of that number."""
    if not values.size:
        return b""
    return _doubles_head(field, values.size) + values.astype("<f8", copy=False).tobytes()


@lru_cache(maxsize=16)
def _step(time_ns: int, step: int) -> bytes:
    # All four messages begin with these fields, and three of a step's with the same values.
    return pb.State(time_ns=time_ns, step=step).SerializeToString()


@lru_cache(maxsize=64)
def _doubles_head(field: int, count: int) -> bytes:
    return _varint(field << 3 | _LENGTH_DELIMITED) + _varint(8 * count)


@lru_cache(maxsize=16)
def _source(source: str) -> bytes:
    return pb.Action(source=source).SerializeToString()


@lru_cache(maxsize=16)
def _terms(names: tuple[str, ...]) -> Template:
    return Template(pb.Reward(terms=[pb.Reward.Term(name=name, value=NUMBER) for name in names], total=NUMBER))


def _varint(value: int) -> bytes:
    # Seven bits a byte, the lower first; all but the last are marked as not the last.
    low, rest = value & 127, value >> 7
    return bytes((low | 128,)) + _varint(rest) if rest else bytes((low,))


# What stands in a prototype for what is to come. No text has these bytes in it: they are not UTF-8.
NUMBER: Final[float] = struct.unpack("<d", b"\xfe" * 8)[0]
MOMENT: Final = Timestamp(seconds=2**35 - 1, nanos=2**31 - 1)

_NUMBER_BYTES: Final = struct.pack("<d", NUMBER)
_MOMENT_BYTES: Final = MOMENT.SerializeToString()
_PLACE: Final = re.compile(b"(" + re.escape(_NUMBER_BYTES) + b"|" + re.escape(_MOMENT_BYTES) + b")")


class Template:
    """A message in which nothing but numbers and times changes: laid out once by protobuf, then packed in one go.

    Its bytes differ from protobuf's own in two ways that every parser reads alike: a number that is 0 is written out,
    and a time has always the same length.
    """

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
    return bytes((0x08, *_long_varint(seconds), 0x10, *_long_varint(nanos)))


def _long_varint(value: int) -> tuple[int, int, int, int, int]:
    # Five times seven bits, the lower first; all but the last are marked as not the last.
    return value & 127 | 128, value >> 7 & 127 | 128, value >> 14 & 127 | 128, value >> 21 & 127 | 128, value >> 28
