"""The records of an MCAP file, one after the other, with the byte each begins at (https://mcap.dev/spec).

A chunk never unpacks to more than its declared size, which is bounded.
"""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import IO, Final, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.records import Chunk

from waypointctl.limits import limit
from waypointctl.log.opening import MAGIC, OverLimit

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
        CutShort: a record is longer than the rest of the file.
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
            raise OverLimit("log-record", f"bytes in the record at byte {offset}", length, size)
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
    """Return size and hash of bytes, for messages."""
    return f"{len(data)} bytes, {hashlib.sha256(data).hexdigest()[:12]}"


def message_head(chunk: bytes, begin: int) -> tuple[int, int]:
    """Return channel and log time [ns] of the message whose body begins at `begin` of an uncompressed chunk."""
    channel, _, log_time_ns, _ = _MESSAGE.unpack_from(chunk, begin)
    return channel, log_time_ns


def raw_message(body: bytes) -> RawMessage:
    """Read the body of a message record."""
    channel, sequence, log_time_ns, publish_time_ns = _MESSAGE.unpack_from(body)
    return RawMessage(channel, sequence, log_time_ns, publish_time_ns, body[_MESSAGE.size :])


_UNSAID: Final = -1  # by zstd's frame: how much it unpacks to


def chunk_bytes(record: Record) -> bytes:
    """Return the uncompressed records of a chunk, its size and checksum checked.

    Raises:
        OverLimit: it unpacks to more than is read.
        one of DAMAGE: it is not what was written.
    """
    chunk = Chunk.read(body_stream(record.body))
    if chunk.uncompressed_size > limit("log-chunk"):
        raise OverLimit("log-chunk", "bytes in one chunk", chunk.uncompressed_size)
    data = _decompressed(chunk)
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk unpacks to {len(data)} bytes; declared were {chunk.uncompressed_size}")
    crc = zlib.crc32(data)
    if chunk.uncompressed_crc not in (0, crc):
        raise ValueError(f"the checksum of a chunk is {crc:#010x}, written was {chunk.uncompressed_crc:#010x}")
    return data


def _decompressed(chunk: Chunk) -> bytes:
    match chunk.compression:
        case "zstd":
            return _zstd(chunk.data, chunk.uncompressed_size)
        case "lz4":
            return _lz4(chunk.data, chunk.uncompressed_size)
        case "":
            return chunk.data
        case other:
            raise ValueError(f"a chunk is compressed with {other[:20]!r}; allowed are zstd, lz4, and nothing")


def _zstd(data: bytes, size: int) -> bytes:
    said = zstandard.frame_content_size(data)
    if said not in (size, _UNSAID):  # the frame's size decides how much memory is taken
        raise ValueError(f"zstd declares {said} bytes, the chunk {size}")
    return zstandard.ZstdDecompressor().decompress(data, max_output_size=max(size, 1), allow_extra_data=False)


def _lz4(data: bytes, size: int) -> bytes:
    import lz4.frame  # peers write it, waypointctl does not

    decompressor = lz4.frame.LZ4FrameDecompressor()
    try:
        unpacked: bytes = decompressor.decompress(data, max_length=size + 1)
    except RuntimeError as error:
        raise ValueError(str(error)) from error
    if decompressor.unused_data or not decompressor.eof:
        raise ValueError("a chunk has more or less lz4 data than it declares")
    return unpacked
