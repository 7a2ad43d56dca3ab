"""The summary at a log's end: what is in the file and where, so that a reader can go straight to it."""

from __future__ import annotations

import zlib
from collections import Counter

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from waypointctl.log.chunk import SealedChunk, encoded


class Summary:
    """Is told of everything that goes into a file."""

    def __init__(self) -> None:
        """Begin with an empty file."""
        self.schemas: list[Schema] = []
        self.channels: list[Channel] = []
        self.attachments: list[AttachmentIndex] = []
        self.metadata: list[MetadataIndex] = []
        self._chunks: list[ChunkIndex] = []
        self._counts: Counter[int] = Counter()  # messages by channel

    def add_chunk(self, chunk: SealedChunk) -> None:
        """Take note of a chunk that has been written."""
        self._chunks.append(chunk.index)
        self._counts.update(chunk.counts)

    def encode(self, start: int) -> bytes:
        """Return the summary section and the footer, for byte `start` of the file."""
        groups: dict[Opcode, list[McapRecord]] = {
            Opcode.SCHEMA: [*self.schemas],
            Opcode.CHANNEL: [*self.channels],
            Opcode.STATISTICS: [self._statistics()],
            Opcode.CHUNK_INDEX: [*self._chunks],
            Opcode.ATTACHMENT_INDEX: [*self.attachments],
            Opcode.METADATA_INDEX: [*self.metadata],
        }
        section, offsets = b"", b""
        for opcode, records in groups.items():
            group = b"".join(encoded(record) for record in records)
            offsets += encoded(SummaryOffset(opcode, start + len(section), len(group)))
            section += group
        footer = Footer(summary_start=start, summary_offset_start=start + len(section), summary_crc=0)
        section += offsets
        footer.summary_crc = zlib.crc32(section + encoded(footer)[:-4])  # of all before the checksum itself
        return section + encoded(footer)

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self.attachments),
            channel_count=len(self.channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=max((chunk.message_end_time for chunk in self._chunks), default=0),
            message_start_time=min((chunk.message_start_time for chunk in self._chunks), default=0),
            metadata_count=len(self.metadata),
            schema_count=len(self.schemas),
        )
