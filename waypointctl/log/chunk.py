"""The chunk that is being filled, and what becomes of it: a record of compressed messages and their index.

Every message of a flight passes here, so its record is packed in one go; mcap's own writer, which builds it field by
field, takes several times as long.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import Final

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk, ChunkIndex, McapRecord

_MESSAGE: Final = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log_time, publish_time
_MESSAGE_INDEX: Final = struct.Struct("<BQHI")  # opcode, length, channel, bytes of entries
_MESSAGE_OPCODE: Final = int(Opcode.MESSAGE)  # packed twice as fast as the enumeration's member
_HEAD_BYTES: Final = 9  # opcode and length, which the length does not count
MESSAGE_BYTES: Final = _MESSAGE.size  # of a message record around its data
ZSTD_LEVEL: Final = 1  # of measured floats, higher levels make 1 % less for half as much time again


class Channel:
    """A topic that is open for messages."""

    __slots__ = ("entries", "id", "sequence")

    def __init__(self, id: int) -> None:
        """Begin a channel without messages."""
        self.id = id
        self.sequence = 0
        self.entries: list[int] = []  # of the open chunk: log time and offset of each message, by turns


def encoded(record: McapRecord) -> bytes:
    """Return a record as it stands in a file."""
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    return data


class OpenChunk:
    """Collects records until it is sealed, and is empty again then."""

    def __init__(self, channels: Sequence[Channel]) -> None:
        """Begin a chunk for messages of `channels`, which may grow."""
        self._channels = channels
        self._records = bytearray()
        self._compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)

    def __len__(self) -> int:
        """Return how many bytes it has, before compression."""
        return len(self._records)

    def define(self, record: McapRecord) -> None:
        """Add a schema or a channel."""
        self._records += encoded(record)

    def append(self, channel: Channel, log_time_ns: int, publish_time_ns: int, data: bytes) -> None:
        """Add a message."""
        records = self._records
        channel.entries += (log_time_ns, len(records))
        length = _MESSAGE.size - _HEAD_BYTES + len(data)
        records += _MESSAGE.pack(_MESSAGE_OPCODE, length, channel.id, channel.sequence, log_time_ns, publish_time_ns)
        records += data
        channel.sequence += 1

    def seal(self, offset: int) -> tuple[bytes, ChunkIndex] | None:
        """End the chunk, which will stand at byte `offset` of the file; None if it has no message.

        Return it with its message indexes, and its own index.
        """
        # In the order in which they first appear, as mcap's writer has them.
        used = sorted((channel for channel in self._channels if channel.entries), key=lambda it: it.entries[1])
        if not used:
            return None
        records = bytes(self._records)
        chunk = Chunk(
            compression="zstd",
            data=self._compressor.compress(records),
            message_start_time=min(min(channel.entries[::2]) for channel in used),
            message_end_time=max(max(channel.entries[::2]) for channel in used),
            uncompressed_crc=zlib.crc32(records),
            uncompressed_size=len(records),
        )
        data = encoded(chunk)
        index = chunk_index(chunk, offset, len(data))
        for channel in used:
            index.message_index_offsets[channel.id] = offset + len(data)
            data += _message_index(channel)
            channel.entries.clear()
        index.message_index_length = len(data) - index.chunk_length
        self._records.clear()
        return data, index


def chunk_index(chunk: Chunk, offset: int, length: int) -> ChunkIndex:
    """Return the index of a chunk whose record of `length` bytes stands at byte `offset`, without message indexes."""
    return ChunkIndex(
        message_start_time=chunk.message_start_time,
        message_end_time=chunk.message_end_time,
        chunk_start_offset=offset,
        chunk_length=length,
        message_index_offsets={},
        message_index_length=0,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        uncompressed_size=chunk.uncompressed_size,
    )


def _message_index(channel: Channel) -> bytes:
    size = 8 * len(channel.entries)
    head = _MESSAGE_INDEX.pack(Opcode.MESSAGE_INDEX, _MESSAGE_INDEX.size - _HEAD_BYTES + size, channel.id, size)
    return head + struct.pack(f"<{len(channel.entries)}Q", *channel.entries)
