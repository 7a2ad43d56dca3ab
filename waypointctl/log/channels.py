"""The MCAP file under a log: what stands before the messages, channels, the size of a chunk, the file's end."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from typing import Final, Protocol

from google.protobuf.message import Message as ProtobufMessage
from mcap import records as mcap
from mcap_protobuf.schema import build_file_descriptor_set

from waypointctl.log.chunk import MESSAGE_BYTES, Channel, OpenChunk, encoded
from waypointctl.log.header import LIBRARY, Attachment
from waypointctl.log.records import MAGIC
from waypointctl.log.summary import Summary

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
        name, media_type, data = attachment.name, attachment.media_type, attachment.data
        record = encoded(mcap.Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data))
        index = mcap.AttachmentIndex(
            offset=self._offset,
            length=len(record),
            log_time=0,
            create_time=0,
            data_size=len(data),
            name=name,
            media_type=media_type,
        )
        self._summary.attachments.append(index)
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
        chunk = self._chunk.seal(self._offset)
        if chunk is not None:
            self._summary.add_chunk(chunk)
            self._put(chunk.data)

    def _put(self, data: bytes) -> None:
        self._stream.write(data)
        self._offset += len(data)
        self._crc = zlib.crc32(data, self._crc)
