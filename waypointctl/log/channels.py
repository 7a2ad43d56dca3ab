"""The MCAP file under a log: what stands before the messages, channels, chunks, and the summary at its end."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Mapping
from typing import Final, Protocol

from google.protobuf.message import Message as ProtobufMessage
from mcap import records as mcap
from mcap.opcode import Opcode
from mcap_protobuf.schema import build_file_descriptor_set

from waypointctl.log.chunk import MESSAGE_BYTES, Channel, OpenChunk, encoded
from waypointctl.log.header import LIBRARY, Attachment
from waypointctl.log.opening import MAGIC

CHUNK_BYTES: Final = 256 * 1024  # before compression; only a single message larger than this makes a larger chunk


class ByteSink(Protocol):
    """What a file is written to."""

    def write(self, data: bytes, /) -> int:
        """Take whole records."""

    def flush(self) -> None:
        """Hand on what was taken."""


class ChannelWriter:
    """Writes protobuf messages to channels. A chunk ends when it is full, or when it is flushed."""

    def __init__(self, stream: ByteSink, library: str = LIBRARY) -> None:
        """Begin an MCAP file in `stream`, which stands at its start; `library` is named as what wrote it."""
        self._stream = stream
        self._offset = 0
        self._crc = 0  # of all that has been put
        self._summary = Summary()
        self._channels: list[Channel] = []
        self._schemas: dict[type[ProtobufMessage], int] = {}
        self._chunk = OpenChunk(self._channels)
        self._put(MAGIC)
        self._put(encoded(mcap.Header(profile="", library=library)))

    @property
    def topics(self) -> dict[int, str]:
        """The topic of each channel that has been opened."""
        return {channel.id: channel.topic for channel in self._summary.channels}

    def attach(self, attachment: Attachment) -> None:
        """Write an attachment; it has no times, because nothing but the simulation has a clock."""
        it = mcap.Attachment(0, 0, attachment.name, attachment.media_type, attachment.data)
        record = encoded(it)
        self._summary.attachments.append(attachment_index(it, self._offset, len(record)))
        self._put(record)

    def describe(self, name: str, metadata: Mapping[str, str]) -> None:
        """Write a metadata record."""
        record = encoded(mcap.Metadata(name=name, metadata=dict(metadata)))
        self._summary.metadata.append(mcap.MetadataIndex(offset=self._offset, length=len(record), name=name))
        self._put(record)

    def open(self, topic: str, schema: type[ProtobufMessage]) -> Channel:
        """Announce a topic whose messages are of `schema`; return what its messages are written to."""
        channel = Channel(len(self._channels) + 1)
        record = mcap.Channel(
            id=channel.id, topic=topic, message_encoding="protobuf", metadata={}, schema_id=self._schema(schema)
        )
        self._channels.append(channel)
        self._summary.channels.append(record)
        self._chunk.define(record)
        return channel

    def write(self, channel: Channel, log_time_ns: int, publish_time_ns: int, data: bytes) -> None:
        """Write one message to an open channel."""
        if len(self._chunk) + MESSAGE_BYTES + len(data) > CHUNK_BYTES:
            self._seal()
        self._chunk.append(channel, log_time_ns, publish_time_ns, data)

    def flush(self) -> None:
        """End the chunk and hand everything to the operating system."""
        self._seal()
        self._stream.flush()

    def finish(self) -> None:
        """Write the index and the end of the file; the stream stays open."""
        self._seal()
        self._put(encoded(mcap.DataEnd(self._crc)))
        self._put(self._summary.encode(self._offset))
        self._put(MAGIC)

    def _schema(self, schema: type[ProtobufMessage]) -> int:
        if schema not in self._schemas:
            record = mcap.Schema(
                id=len(self._schemas) + 1,
                data=build_file_descriptor_set(schema).SerializeToString(),
                encoding="protobuf",
                name=schema.DESCRIPTOR.full_name,
            )
            self._schemas[schema] = record.id
            self._summary.schemas.append(record)
            self._chunk.define(record)
        return self._schemas[schema]

    def _seal(self) -> None:
        sealed = self._chunk.seal(self._offset)
        if sealed is not None:
            data, index = sealed
            self._summary.chunks.append(index)
            for channel_id in index.message_index_offsets:
                self._summary.counts[channel_id] = self._channels[channel_id - 1].sequence
            self._put(data)

    def _put(self, data: bytes) -> None:
        self._stream.write(data)
        self._offset += len(data)
        self._crc = zlib.crc32(data, self._crc)


def attachment_index(it: mcap.Attachment, offset: int, length: int) -> mcap.AttachmentIndex:
    """Return the index of an attachment whose record of `length` bytes stands at byte `offset`."""
    return mcap.AttachmentIndex(
        offset=offset,
        length=length,
        log_time=it.log_time,
        create_time=it.create_time,
        data_size=len(it.data),
        name=it.name,
        media_type=it.media_type,
    )


class Summary:
    """Collects what is in a file, for the summary at its end."""

    def __init__(self) -> None:
        """Begin with an empty file."""
        self.schemas: list[mcap.Schema] = []
        self.channels: list[mcap.Channel] = []
        self.attachments: list[mcap.AttachmentIndex] = []
        self.metadata: list[mcap.MetadataIndex] = []
        self.chunks: list[mcap.ChunkIndex] = []
        self.counts: Counter[int] = Counter()  # messages by channel

    def groups(self) -> dict[Opcode, list[mcap.McapRecord]]:
        """Return what the summary lists, the records of each kind together, in the order of a file."""
        return {
            Opcode.SCHEMA: [*self.schemas],
            Opcode.CHANNEL: [*self.channels],
            Opcode.STATISTICS: [self._statistics()],
            Opcode.CHUNK_INDEX: [*self.chunks],
            Opcode.ATTACHMENT_INDEX: [*self.attachments],
            Opcode.METADATA_INDEX: [*self.metadata],
        }

    def encode(self, start: int) -> bytes:
        """Return the summary section and the footer, for byte `start` of the file."""
        section, offsets = b"", b""
        for opcode, records in self.groups().items():
            group = b"".join(encoded(record) for record in records)
            offsets += encoded(mcap.SummaryOffset(opcode, start + len(section), len(group)))
            section += group
        footer = mcap.Footer(summary_start=start, summary_offset_start=start + len(section), summary_crc=0)
        section += offsets
        footer.summary_crc = zlib.crc32(section + encoded(footer)[:-4])  # of all before the checksum itself
        return section + encoded(footer)

    def _statistics(self) -> mcap.Statistics:
        return mcap.Statistics(
            attachment_count=len(self.attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(self.counts),
            chunk_count=len(self.chunks),
            message_count=self.counts.total(),
            message_end_time=max((chunk.message_end_time for chunk in self.chunks), default=0),
            message_start_time=min((chunk.message_start_time for chunk in self.chunks), default=0),
            metadata_count=len(self.metadata),
            schema_count=len(self.schemas),
        )
