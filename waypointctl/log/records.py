"""The records of an MCAP file, one after the other, with the byte each begins at (https://mcap.dev/spec)."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import IO, Final, NamedTuple

from mcap.data_stream import ReadDataStream

from waypointctl.limits import limit
from waypointctl.log.bounds import OverLimit

MAGIC: Final = b"\x89MCAP0\r\n"
_HEAD: Final = struct.Struct("<BQ")  # opcode, length
_MESSAGE: Final = struct.Struct("<HIQQ")  # channel, sequence, log_time, publish_time


@dataclass(frozen=True, slots=True)
class Record:
    """One record of a file."""

    offset: int
    opcode: int
    body: bytes

    @property
    def head(self) -> bytes:
        """Opcode and length, as they stand in the file before the body."""
        return _HEAD.pack(self.opcode, len(self.body))

    @property
    def raw(self) -> bytes:
        """Its bytes in the file."""
        return self.head + self.body


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
        OverLimit: it is larger than is read.
    """
    most = limit("log-record")
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
        if length > most:
            raise OverLimit("log-record", f"bytes in the record at byte {offset}", length)
        yield Record(offset, opcode, stream.read(length))
        offset += _HEAD.size + length


def inner_spans(chunk: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield the opcode of each record in an uncompressed chunk, and where its body begins and ends.

    Raises:
        ValueError: a record reaches beyond the chunk.
    """
    offset, size = 0, len(chunk)
    while offset < size:
        if offset + _HEAD.size > size:
            raise ValueError("a record's head is cut short")
        opcode, length = _HEAD.unpack_from(chunk, offset)
        begin = offset + _HEAD.size
        offset = begin + length
        if offset > size:
            raise ValueError("a record is cut short")
        yield opcode, begin, offset


def inner_records(chunk: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and body of each record in an uncompressed chunk.

    Raises:
        ValueError: a record reaches beyond the chunk.
    """
    for opcode, begin, end in inner_spans(chunk):
        yield opcode, chunk[begin:end]


def body_stream(body: bytes) -> ReadDataStream:
    """Return a record's body as mcap's record classes read it."""
    return ReadDataStream(BytesIO(body))


def shown(data: bytes) -> str:
    """Return bytes as people can tell them from others."""
    return f"{len(data)} bytes, {hashlib.sha256(data).hexdigest()[:12]}"


def message_head(chunk: bytes, begin: int) -> tuple[int, int]:
    """Return channel and log time [ns] of the message whose body begins at `begin` of an uncompressed chunk."""
    channel, _, log_time_ns, _ = _MESSAGE.unpack_from(chunk, begin)
    return channel, log_time_ns


def raw_message(body: bytes) -> RawMessage:
    """Read the body of a message record."""
    channel, sequence, log_time_ns, publish_time_ns = _MESSAGE.unpack_from(body)
    return RawMessage(channel, sequence, log_time_ns, publish_time_ns, body[_MESSAGE.size :])
