"""The records of an MCAP file, one after the other, with the byte each begins at (https://mcap.dev/spec)."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import IO, Final, NamedTuple

from mcap.data_stream import ReadDataStream

MAGIC: Final = b"\x89MCAP0\r\n"
_SHOWN: Final = 80  # characters of a text
_HEAD: Final = struct.Struct("<BQ")  # opcode, length
_MESSAGE: Final = struct.Struct("<HIQQ")  # channel, sequence, log_time, publish_time


@dataclass(frozen=True, slots=True)
class Record:
    """One record of a file."""

    offset: int
    opcode: int
    body: bytes

    @property
    def raw(self) -> bytes:
        """Its bytes in the file."""
        return _HEAD.pack(self.opcode, len(self.body)) + self.body


class RawMessage(NamedTuple):
    """One message, not yet decoded; a tuple, because it is made for every message of a log."""

    channel: int
    sequence: int
    log_time_ns: int
    publish_time_ns: int
    data: bytes


class CutShort(Exception):
    """The file ends inside the record that begins at `offset`."""

    def __init__(self, offset: int) -> None:
        """Remember where."""
        super().__init__(offset)
        self.offset = offset


def records(stream: IO[bytes], start: int, size: int) -> Iterator[Record]:
    """Yield the records from byte `start` of a file of `size` bytes on, up to the closing magic.

    Raises:
        CutShort: a record says it is longer than what is left of the file.
    """
    stream.seek(start)
    offset = start
    while True:
        head = stream.read(_HEAD.size)
        if head == MAGIC and offset + len(MAGIC) == size:
            return
        if len(head) < _HEAD.size:
            raise CutShort(offset)
        opcode, length = _HEAD.unpack(head)
        if offset + _HEAD.size + length > size:
            raise CutShort(offset)
        yield Record(offset, opcode, stream.read(length))
        offset += _HEAD.size + length


def inner_records(chunk: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and body of each record in an uncompressed chunk.

    Raises:
        ValueError: a record reaches beyond the chunk.
    """
    offset = 0
    while offset < len(chunk):
        if offset + _HEAD.size > len(chunk):
            raise ValueError("a record's head is cut short")
        opcode, length = _HEAD.unpack_from(chunk, offset)
        begin = offset + _HEAD.size
        offset = begin + length
        if offset > len(chunk):
            raise ValueError("a record is cut short")
        yield opcode, chunk[begin:offset]


def body_stream(body: bytes) -> ReadDataStream:
    """Return a record's body as mcap's record classes read it."""
    return ReadDataStream(BytesIO(body))


def excerpt(text: str) -> str:
    """Return as much of a text of a file as is to be shown: it may have millions of characters."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def shown(data: bytes) -> str:
    """Return bytes as people can tell them from others."""
    return f"{len(data)} bytes, {hashlib.sha256(data).hexdigest()[:12]}"


def raw_message(body: bytes) -> RawMessage:
    """Read the body of a message record."""
    channel, sequence, log_time_ns, publish_time_ns = _MESSAGE.unpack_from(body)
    return RawMessage(channel, sequence, log_time_ns, publish_time_ns, body[_MESSAGE.size :])
