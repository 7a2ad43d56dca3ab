"""The MCAP file under a log: channels, sequence numbers, the size of a chunk and when it reaches the disk."""

from __future__ import annotations

from typing import IO, Final

from google.protobuf.message import Message as ProtobufMessage
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import register_schema

from waypointctl import __version__
from waypointctl.log.header import Attachment
from waypointctl.units import NS_PER_S

CHUNK_BYTES: Final = 256 * 1024  # before compression; only a single message larger than this makes a larger chunk
_RECORD_BYTES: Final = 31  # of a message record around its data


class ChannelWriter:
    """Writes protobuf messages to channels, by topic.

    A chunk ends, and all that was written reaches the operating system, when the simulated second changes:
    a killed process loses less than one. No wall clock is asked, so the bytes depend on the messages alone.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        """Begin an MCAP file in `stream`."""
        # chunk_size is kept out of reach: write() ends the chunks, before they are too large rather than after.
        self._mcap = Writer(stream, 2 * CHUNK_BYTES, CompressionType.ZSTD, enable_data_crcs=True)
        self._mcap.start(library=f"waypointctl {__version__}")
        self._channels: dict[str, int] = {}
        self._schemas: dict[type[ProtobufMessage], int] = {}
        self._sequences: dict[str, int] = {}
        self._pending_bytes = 0
        self._second = 0

    def attach(self, attachment: Attachment) -> None:
        """Write an attachment; it has no times, because nothing but the simulation has a clock."""
        self._mcap.add_attachment(0, 0, attachment.name, attachment.media_type, attachment.data)

    def describe(self, name: str, metadata: dict[str, str]) -> None:
        """Write a metadata record."""
        self._mcap.add_metadata(name, metadata)

    def open(self, topic: str, schema: type[ProtobufMessage]) -> None:
        """Announce a topic whose messages are of `schema`."""
        if schema not in self._schemas:
            self._schemas[schema] = register_schema(self._mcap, schema)
        self._channels[topic] = self._mcap.register_channel(topic, "protobuf", self._schemas[schema])
        self._sequences[topic] = 0

    def write(self, topic: str, log_time_ns: int, publish_time_ns: int, data: bytes) -> None:
        """Write one message to an open topic."""
        size = len(data) + _RECORD_BYTES
        second = log_time_ns // NS_PER_S
        if second > self._second or self._pending_bytes + size > CHUNK_BYTES:
            self.flush()
            self._second = max(second, self._second)
        sequence = self._sequences[topic]
        self._sequences[topic] = sequence + 1
        self._pending_bytes += size
        self._mcap.add_message(self._channels[topic], log_time_ns, data, publish_time_ns, sequence)

    def flush(self) -> None:
        """End the chunk and hand everything to the operating system."""
        self._mcap.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
        self._pending_bytes = 0

    def finish(self) -> None:
        """Write the index and the end of the file; the stream stays open."""
        self._mcap.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
