"""Logs taken apart and put together again with something changed, each checksum and index right that is not to lie."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from io import BytesIO
from typing import Any

import zstandard
from mcap import records as mcap
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from waypointctl.log.channels import Summary
from waypointctl.log.chunk import encoded
from waypointctl.log.opening import MAGIC
from waypointctl.log.records import Record, body_stream, chunk_bytes, inner_records, raw_message, records

HEAD_BYTES = 9  # opcode and length of a record

Inner = tuple[int, bytes]  # opcode and body of a record in a chunk


@dataclass
class Chunk:
    """A chunk as its records; what stands in its own fields follows from them, but for what `lies` says."""

    inner: list[Inner]
    compression: str = "zstd"
    lies: dict[str, Any] = field(default_factory=dict)  # fields of mcap.Chunk
    is_indexed: bool = True  # whether it has message indexes and is listed in the summary
    index_lies: dict[str, Any] = field(default_factory=dict)  # fields of mcap.ChunkIndex


Part = mcap.McapRecord | Chunk | bytes | Callable[[int], bytes]


@dataclass
class Forgery:
    """A log's file: what stands before the end of the data, in its order, and how the summary is to lie.

    Attributes:
        header: the header record.
        data: attachments, metadata, chunks; bytes are put in as they are, such as records nobody knows, and what a
            function gives for the byte at which it is to begin.
        summary: is given each record of the summary, and returns what stands in its place.
        tail: bytes after the closing magic.
    """

    header: mcap.Header
    data: list[Part]
    summary: Callable[[list[mcap.McapRecord]], Iterable[mcap.McapRecord]] = lambda records: records
    tail: bytes = b""

    @classmethod
    def of(cls, file: bytes) -> Forgery:
        """Take a whole log apart."""
        header = mcap.Header("", "")
        data: list[Part] = []
        for record in records(BytesIO(file), len(MAGIC), len(file)):
            match record.opcode:
                case Opcode.HEADER:
                    header = mcap.Header.read(body_stream(record.body))
                case Opcode.ATTACHMENT:
                    data.append(mcap.Attachment.read(body_stream(record.body)))
                case Opcode.METADATA:
                    data.append(mcap.Metadata.read(body_stream(record.body)))
                case Opcode.CHUNK:
                    data.append(Chunk([*inner_records(chunk_bytes(record))]))
                case Opcode.DATA_END:
                    break
        return cls(header, data)

    @property
    def chunks(self) -> list[Chunk]:
        return [part for part in self.data if isinstance(part, Chunk)]

    def messages(self, topic: str) -> list[tuple[Chunk, int]]:
        """Return where the messages of a topic are: their chunks, and their places in these."""
        channel = self.channel(topic)
        return [
            (chunk, at)
            for chunk in self.chunks
            for at, (opcode, body) in enumerate(chunk.inner)
            if opcode == Opcode.MESSAGE and raw_message(body).channel == channel
        ]

    def channel(self, topic: str) -> int:
        inner = (record for chunk in self.chunks for record in chunk.inner)
        channels = (mcap.Channel.read(body_stream(body)) for opcode, body in inner if opcode == Opcode.CHANNEL)
        return int(next(it.id for it in channels if it.topic == topic))

    def metadata(self) -> dict[str, str]:
        return next(part.metadata for part in self.data if isinstance(part, mcap.Metadata))

    def attachment(self, name: str) -> mcap.Attachment:
        return next(part for part in self.data if isinstance(part, mcap.Attachment) and part.name == name)

    def file(self) -> bytes:
        """Put it together."""
        out = bytearray(MAGIC + encoded(self.header))
        summary = Summary()
        for part in self.data:
            self._put(out, summary, part)
        out += encoded(mcap.DataEnd(zlib.crc32(out)))
        out += self._summary(summary, len(out))
        return bytes(out + MAGIC + self.tail)

    def _put(self, out: bytearray, summary: Summary, part: Part) -> None:
        offset = len(out)
        match part:
            case bytes():
                out += part
            case _ if callable(part):
                out += part(offset)
            case Chunk():
                data, chunk_index, counts = seal(part, offset)
                out += data
                for opcode, body in part.inner:
                    with suppress(McapError, ValueError, struct.error):  # one that is damaged is listed nowhere
                        _list(summary, opcode, body)
                if part.is_indexed:
                    summary.chunks.append(replace(chunk_index, **part.index_lies))
                    summary.counts.update(counts)
            case mcap.Attachment():
                out += encoded(part)
                times = {"log_time": part.log_time, "create_time": part.create_time}
                size = {"offset": offset, "length": len(out) - offset, "data_size": len(part.data)}
                index = mcap.AttachmentIndex(name=part.name, media_type=part.media_type, **times, **size)
                summary.attachments.append(index)
            case mcap.Metadata():
                out += encoded(part)
                summary.metadata.append(mcap.MetadataIndex(offset, len(out) - offset, part.name))

    def _summary(self, summary: Summary, start: int) -> bytes:
        honest = summary.encode(start)
        parts: list[mcap.McapRecord] = []
        for record in records(BytesIO(honest + MAGIC), 0, len(honest) + len(MAGIC)):
            parts.append(SUMMARY_TYPES[record.opcode].read(body_stream(record.body)))
        *listed, footer = self.summary(parts)
        section = b"".join(map(encoded, listed))
        assert isinstance(footer, mcap.Footer)
        footer.summary_crc = zlib.crc32(section + encoded(footer)[:-4])
        return section + encoded(footer)


def _list(summary: Summary, opcode: int, body: bytes) -> None:
    """List a definition, in the place of an earlier one."""
    if opcode == Opcode.SCHEMA:
        schema = mcap.Schema.read(body_stream(body))
        summary.schemas = [*(it for it in summary.schemas if it.id != schema.id), schema]
    elif opcode == Opcode.CHANNEL:
        channel = mcap.Channel.read(body_stream(body))
        summary.channels = [*(it for it in summary.channels if it.id != channel.id), channel]


SUMMARY_TYPES: dict[int, Any] = {
    Opcode.SCHEMA: mcap.Schema,
    Opcode.CHANNEL: mcap.Channel,
    Opcode.STATISTICS: mcap.Statistics,
    Opcode.CHUNK_INDEX: mcap.ChunkIndex,
    Opcode.ATTACHMENT_INDEX: mcap.AttachmentIndex,
    Opcode.METADATA_INDEX: mcap.MetadataIndex,
    Opcode.SUMMARY_OFFSET: mcap.SummaryOffset,
    Opcode.FOOTER: mcap.Footer,
}


def seal(chunk: Chunk, offset: int) -> tuple[bytes, mcap.ChunkIndex, dict[int, int]]:
    """Return a chunk's record with its message indexes, for byte `offset` of a file; its index; messages by channel."""
    data = b"".join(Record(0, opcode, body).raw for opcode, body in chunk.inner)
    entries: dict[int, list[tuple[int, int]]] = {}
    at = 0
    for opcode, body in chunk.inner:
        if opcode == Opcode.MESSAGE and len(body) >= 22:
            raw = raw_message(body)
            entries.setdefault(raw.channel, []).append((raw.log_time_ns, at))
        at += HEAD_BYTES + len(body)
    times = [time for found in entries.values() for time, _ in found]
    record = mcap.Chunk(
        compression=chunk.compression,
        data=compressed(data, chunk.compression),
        message_start_time=min(times, default=0),
        message_end_time=max(times, default=0),
        uncompressed_crc=zlib.crc32(data),
        uncompressed_size=len(data),
    )
    record = replace(record, **chunk.lies)
    out = encoded(record)
    length, offsets = len(out), {}
    for channel, found in entries.items() if chunk.is_indexed else ():
        offsets[channel] = offset + len(out)
        out += encoded(mcap.MessageIndex(channel, found))
    index = mcap.ChunkIndex(
        message_start_time=record.message_start_time,
        message_end_time=record.message_end_time,
        chunk_start_offset=offset,
        chunk_length=length,
        message_index_offsets=offsets,
        message_index_length=len(out) - length,
        compression=record.compression,
        compressed_size=len(record.data),
        uncompressed_size=record.uncompressed_size,
    )
    return out, index, {channel: len(found) for channel, found in entries.items()}


def compressed(data: bytes, compression: str) -> bytes:
    if compression == "zstd":
        return zstandard.ZstdCompressor(level=1).compress(data)
    if compression == "lz4":
        import lz4.frame

        packed: bytes = lz4.frame.compress(data)
        return packed
    return data


def with_payload(body: bytes, change: Callable[[bytes], bytes]) -> bytes:
    """Return a message's body with other data."""
    return body[:22] + change(body[22:])
