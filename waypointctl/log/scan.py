"""One pass over a log: every checksum checked, every message counted, nothing kept but what is small.

Whatever is wrong with a file as MCAP is found here, before its first message is given out. What the messages say is
decoded, and found wrong, only while they are read. Sizes are checked before memory is taken (bounds.py).
"""

from __future__ import annotations

import os
import re
import struct
import zlib
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Footer, Header, Metadata, Schema

from waypointctl.errors import LogError
from waypointctl.log.header import METADATA_NAME, SCHEMA_VERSION, ChunkPlace, LogIndex, TopicSummary
from waypointctl.log.opening import (
    DAMAGE,
    MAGIC,
    PART,
    Bounds,
    OverLimit,
    check_magic,
    damaged,
    nothing_flown,
    open_file,
)
from waypointctl.log.records import CutShort, Record, body_stream, chunk_bytes, inner_spans, message_head, records
from waypointctl.paths import is_being_written

_VERSION: Final = re.compile("[0-9]{1,9}")  # Python reads no number of thousands of digits


class _Tally:
    """Counts one channel's messages."""

    __slots__ = ("count", "first_ns", "last_ns")

    def __init__(self) -> None:
        self.count = 0
        self.first_ns = 1 << 64
        self.last_ns = -1

    def add(self, time_ns: int) -> None:
        self.count += 1
        if time_ns < self.first_ns:
            self.first_ns = time_ns
        if time_ns > self.last_ns:
            self.last_ns = time_ns

    def summary(self, name: str, schema: str) -> TopicSummary:
        times = (self.first_ns, self.last_ns) if self.count else (None, None)
        return TopicSummary(name, schema, self.count, *times)


def scan(path: Path, *, allow_truncated: bool) -> LogIndex:
    """Read and check the whole file.

    Raises:
        LogError: it cannot be read, is damaged, is cut short (unless `allow_truncated`), is over a limit, or is not
            waypointctl's.
    """
    with open_file(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        check_magic(stream, path, size)
        stream.seek(-len(MAGIC), os.SEEK_END)
        has_end = stream.read() == MAGIC and size > len(MAGIC)
        survey = _Survey(str(path), Bounds(size))
        try:
            for record in records(stream, len(MAGIC), size):
                survey.take(record)
        except OverLimit as error:
            raise error.refusal(str(path)) from None
        except CutShort as cut:
            if has_end:
                raise damaged(str(path), cut.offset, "a record reaches beyond the end of the file") from None
            if not allow_truncated:
                raise _truncated(path, size, survey) from None
    return survey.contents(size, is_complete=has_end)


def _truncated(path: Path, size: int, survey: _Survey) -> LogError:
    if path.suffix == PART and not survey.has_begun:
        return nothing_flown(path)
    last_ns = max((chunk.last_ns for chunk in survey.chunks), default=None)
    kept = "it has no message" if last_ns is None else f"its messages reach to {last_ns / 1e9:.3f} s"
    if is_being_written(path):
        return LogError(
            f"is being written, {kept}: its flight is still running",
            where=str(path),
            hint="Wait for its end; `waypointctl info` shows its contents so far.",
        )
    return LogError(
        f"is cut short at byte {size}, {kept}: its writer was killed, or it was not copied to its end",
        where=str(path),
        hint="`waypointctl info` shows its contents; `waypointctl run --resume` continues a flight that was killed.",
    )


class _Survey:
    """Takes the records of one file in their order."""

    def __init__(self, path: str, bounds: Bounds) -> None:
        self._path = path
        self._bounds = bounds
        self.chunks: list[ChunkPlace] = []
        self.has_begun = False  # there is metadata, which comes after the attachments
        self._library = ""
        self._metadata: dict[str, str] | None = None
        self._attachments: dict[str, bytes] = {}
        self._media_types: dict[str, str] = {}
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._tallies: dict[int, _Tally] = {}
        self._crc = zlib.crc32(MAGIC)  # of the data section, then of the summary section
        self._ended = False
        self._footed = False

    def take(self, record: Record) -> None:
        """Check one record and keep what is to be kept of it."""
        try:
            self._read(record)
        except OverLimit as error:
            raise error.refusal(self._path) from None
        except DAMAGE as error:
            raise damaged(self._path, record.offset, str(error) or type(error).__name__) from None
        if record.opcode == Opcode.DATA_END:
            self._crc, self._ended = 0, True
        else:
            self._crc = zlib.crc32(record.body, zlib.crc32(record.head, self._crc))

    def contents(self, size: int, *, is_complete: bool) -> LogIndex:
        """Return what was found, if it is a log of ours that this version can read."""
        if is_complete and not (self._ended and self._footed):
            raise damaged(self._path, size, "its end has no footer")
        if self._metadata is None:
            if not is_complete and Path(self._path).suffix == PART:
                raise nothing_flown(Path(self._path))
            if not is_complete:
                raise LogError("is cut short before its metadata, so it cannot be read", where=self._path)
            raise LogError("is an MCAP file, but not a log of waypointctl", where=self._path)
        _check_version(self._path, self._metadata.get("schema_version", ""))
        return LogIndex(
            library=self._library,
            metadata=MappingProxyType(self._metadata),
            attachments=MappingProxyType(self._attachments),
            media_types=MappingProxyType(self._media_types),
            schemas=MappingProxyType(self._schemas),
            channels=MappingProxyType(self._channels),
            topics=MappingProxyType({channel: self._topic(channel) for channel in self._channels}),
            chunks=tuple(self.chunks),
            size_bytes=size,
            is_complete=is_complete,
        )

    def _topic(self, number: int) -> TopicSummary:
        channel = self._channels[number]
        schema = self._schemas.get(channel.schema_id)
        return self._tallies[number].summary(channel.topic, "" if schema is None else schema.name)

    def _read(self, record: Record) -> None:
        match record.opcode:
            case Opcode.HEADER:
                self._library = Header.read(body_stream(record.body)).library
            case Opcode.ATTACHMENT:
                self._attach(record)
            case Opcode.METADATA:
                self._bounds.take_description(len(record.body))
                metadata = Metadata.read(body_stream(record.body))
                self._bounds.take_entries(len(metadata.metadata))
                if metadata.name == METADATA_NAME:
                    self._metadata, self.has_begun = metadata.metadata, True
            case Opcode.CHUNK:
                self._count(record)
            case Opcode.DATA_END:
                _check_crc(DataEnd.read(body_stream(record.body)).data_section_crc, self._crc)
            case Opcode.FOOTER:
                self._footed = True
                crc = zlib.crc32(record.body[:-4], zlib.crc32(record.head, self._crc))
                _check_crc(Footer.read(body_stream(record.body)).summary_crc, crc)

    def _attach(self, record: Record) -> None:
        self._bounds.take_attachment(len(record.body))
        attachment = Attachment.read(body_stream(record.body))
        (crc,) = struct.unpack("<I", record.body[-4:])
        _check_crc(crc, zlib.crc32(memoryview(record.body)[:-4]))
        self._attachments[attachment.name] = attachment.data
        self._media_types[attachment.name] = attachment.media_type

    def _count(self, record: Record) -> None:
        chunk = Chunk.read(body_stream(record.body))
        self._bounds.take_chunk(chunk.uncompressed_size)
        data = chunk_bytes(record)
        tallies, count = self._tallies, 0
        for opcode, begin, end in inner_spans(data):
            count += 1
            if opcode == Opcode.MESSAGE:
                channel, time_ns = message_head(data, begin)
                if channel not in tallies:
                    raise ValueError(f"a message of channel {channel}, which is not defined")
                tallies[channel].add(time_ns)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._define(opcode, data[begin:end])
        self._bounds.take_messages(count)
        self.chunks.append(ChunkPlace(record.offset, chunk.message_start_time, chunk.message_end_time))

    def _define(self, opcode: int, body: bytes) -> None:
        known: dict[int, Any] = self._schemas if opcode == Opcode.SCHEMA else self._channels
        it = (Schema if opcode == Opcode.SCHEMA else Channel).read(body_stream(body))
        if it.id not in known:
            self._bounds.take_description(len(body))
            self._bounds.take_entries(1)
            known[it.id] = it
            if opcode == Opcode.CHANNEL:
                self._tallies[it.id] = _Tally()
        elif known[it.id] != it:  # MCAP allows it to be there again, and nothing else under its number
            name = "schema" if opcode == Opcode.SCHEMA else "channel"
            raise ValueError(f"{name} {it.id} is defined again as another")


def _check_crc(written: int, calculated: int) -> None:
    # Zero means that the writer made no checksum.
    if written not in (0, calculated):
        raise ValueError(f"the checksum is {calculated:#010x}, written was {written:#010x}")


def _check_version(path: str, text: str) -> None:
    if not _VERSION.fullmatch(text):
        shown = text if len(text) <= 20 else f"{text[:20]}..."
        raise LogError(f"has the schema version {shown!r} in its metadata; a whole number is expected", where=path)
    if int(text) != SCHEMA_VERSION:
        age = "a newer" if int(text) > SCHEMA_VERSION else "an older"
        raise LogError(
            f"has the schema version {int(text)}; this waypointctl reads {SCHEMA_VERSION}",
            where=path,
            hint=f"It was written by {age} version of waypointctl: read it with that version.",
        )
