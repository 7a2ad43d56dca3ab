"""One pass over a log: every checksum checked, every message counted, nothing kept but what is small.

Whatever is wrong with a file as MCAP is found here, before its first message is given out. What the messages say is
decoded, and found wrong, only while they are read.
"""

from __future__ import annotations

import os
import re
import struct
import zlib
from pathlib import Path
from types import MappingProxyType
from typing import IO, Final

from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Footer, Header, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream
from zstandard import ZstdError

from waypointctl.display_text import shell_word
from waypointctl.errors import LogError
from waypointctl.log.contents import ChunkPlace, Contents, TopicSummary
from waypointctl.log.header import METADATA_NAME, SCHEMA_VERSION
from waypointctl.log.records import MAGIC, CutShort, Record, body_stream, inner_records, raw_message, records
from waypointctl.paths import command_for_mission, command_for_plan

# What mcap, zstd and protobuf raise over bytes that are not what they should be.
DAMAGE = (struct.error, ValueError, KeyError, MemoryError, OverflowError, McapError, ZstdError, DecodeError)
PART: Final = ".part"  # of the name of a log that is being written
_VERSION: Final = re.compile("[0-9]{1,9}")  # Python reads no number of thousands of digits


class _Tally:
    """Counts one channel's messages."""

    def __init__(self, name: str, schema: str) -> None:
        self._name = name
        self._schema = schema
        self._count = 0
        self._first_ns: int | None = None
        self._last_ns: int | None = None

    def add(self, time_ns: int) -> None:
        self._count += 1
        self._first_ns = time_ns if self._first_ns is None else min(self._first_ns, time_ns)
        self._last_ns = time_ns if self._last_ns is None else max(self._last_ns, time_ns)

    def summary(self) -> TopicSummary:
        return TopicSummary(self._name, self._schema, self._count, self._first_ns, self._last_ns)


def scan(path: Path, *, allow_truncated: bool) -> Contents:
    """Read and check the whole file.

    Raises:
        LogError: it cannot be read, is damaged, is cut short (unless `allow_truncated`), or is not waypointctl's.
    """
    survey = _Survey(str(path))
    with open_file(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        _check_magic(stream, path, size)
        stream.seek(-len(MAGIC), os.SEEK_END)
        has_end = stream.read() == MAGIC and size > len(MAGIC)
        try:
            for record in records(stream, len(MAGIC), size):
                survey.take(record)
        except CutShort as cut:
            if has_end:
                raise damaged(str(path), cut.offset, "a record reaches beyond the end of the file") from None
            if not allow_truncated:
                raise _truncated(path, size, survey) from None
    return survey.contents(size, is_complete=has_end)


def open_file(path: Path) -> IO[bytes]:
    """Open a log for reading, or say why it cannot be."""
    try:
        return open(path, "rb")
    except FileNotFoundError:
        raise LogError("no such log", where=str(path)) from None
    except IsADirectoryError:
        raise LogError("is a folder; a log is one .mcap file", where=str(path)) from None
    except OSError as error:
        raise LogError(f"cannot be read: {error.strerror}", where=str(path)) from None


def damaged(path: str, offset: int, what: str) -> LogError:
    """Return the error for a file whose bytes are not those that were written."""
    return LogError(
        f"is damaged at byte {offset}: {what}",
        where=path,
        mend="Its bytes are not those that were written: take another copy of it.",
    )


def chunk_bytes(record: Record) -> bytes:
    """Return the uncompressed records of a chunk, its checksum checked.

    Raises:
        one of DAMAGE: it is not what was written.
    """
    chunk = Chunk.read(body_stream(record.body))
    try:
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    except RuntimeError as error:  # from lz4, which another tool may have compressed the log with
        raise ValueError(str(error)) from error
    return stream.read(length)


def _check_magic(stream: IO[bytes], path: Path, size: int) -> None:
    if path.suffix == PART and size < len(MAGIC) and MAGIC.startswith(stream.read(size)):
        raise _nothing_flown(path)
    if size == 0:
        raise LogError("is empty", where=str(path))
    if stream.read(len(MAGIC)) != MAGIC:
        mend = command_for_mission(str(path)) or command_for_plan(str(path)) or "a log is what `waypointctl run` writes"
        raise LogError("is not an MCAP file", where=str(path), mend=f"{mend[0].upper()}{mend[1:]}.")


def _nothing_flown(path: Path) -> LogError:
    return LogError(
        "nothing was flown yet: its flight was killed before it began, or is only just beginning",
        where=str(path),
        mend=f"Run the mission again: `waypointctl run MISSION.yaml --out {shell_word(str(path.with_suffix('')))} "
        "--force`.",
    )


def _truncated(path: Path, size: int, survey: _Survey) -> LogError:
    if path.suffix == PART and not survey.has_begun:
        return _nothing_flown(path)
    last_ns = max((chunk.last_ns for chunk in survey.chunks), default=None)
    kept = "it has no message" if last_ns is None else f"its messages reach to {last_ns / 1e9:.3f} s"
    return LogError(
        f"is cut short at byte {size}, {kept}: its writer was killed, or it was not copied to its end",
        where=str(path),
        mend="The flight was killed, is not over, or the file was cut: `waypointctl info` shows what there is, "
        "`waypointctl run --resume` goes on with a flight that was killed.",
    )


class _Survey:
    """Takes the records of one file in their order."""

    def __init__(self, path: str) -> None:
        self._path = path
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
        except DAMAGE as error:
            raise damaged(self._path, record.offset, str(error) or type(error).__name__) from None
        if record.opcode == Opcode.DATA_END:
            self._crc, self._ended = 0, True
        else:
            self._crc = zlib.crc32(record.raw, self._crc)

    def contents(self, size: int, *, is_complete: bool) -> Contents:
        """Return what was found, if it is a log of ours that this version can read."""
        if is_complete and not (self._ended and self._footed):
            raise damaged(self._path, size, "its end has no footer")
        if self._metadata is None:
            if not is_complete and Path(self._path).suffix == PART:
                raise _nothing_flown(Path(self._path))
            if not is_complete:
                raise LogError("is cut short before its metadata: nothing of it can be read", where=self._path)
            raise LogError("is an MCAP file, but not a log of waypointctl", where=self._path)
        _check_version(self._path, self._metadata.get("schema_version", ""))
        return Contents(
            library=self._library,
            metadata=MappingProxyType(self._metadata),
            attachments=MappingProxyType(self._attachments),
            media_types=MappingProxyType(self._media_types),
            schemas=MappingProxyType(self._schemas),
            channels=MappingProxyType(self._channels),
            topics=MappingProxyType({channel: tally.summary() for channel, tally in self._tallies.items()}),
            chunks=tuple(self.chunks),
            size_bytes=size,
            is_complete=is_complete,
        )

    def _read(self, record: Record) -> None:
        match record.opcode:
            case Opcode.HEADER:
                self._library = Header.read(body_stream(record.body)).library
            case Opcode.ATTACHMENT:
                self._attach(record)
            case Opcode.METADATA:
                metadata = Metadata.read(body_stream(record.body))
                if metadata.name == METADATA_NAME:
                    self._metadata, self.has_begun = metadata.metadata, True
            case Opcode.CHUNK:
                self._count(record)
            case Opcode.DATA_END:
                _check_crc(DataEnd.read(body_stream(record.body)).data_section_crc, self._crc)
            case Opcode.FOOTER:
                self._footed = True
                _check_crc(Footer.read(body_stream(record.body)).summary_crc, zlib.crc32(record.raw[:-4], self._crc))

    def _attach(self, record: Record) -> None:
        attachment = Attachment.read(body_stream(record.body))
        (crc,) = struct.unpack("<I", record.body[-4:])
        _check_crc(crc, zlib.crc32(record.body[:-4]))
        self._attachments[attachment.name] = attachment.data
        self._media_types[attachment.name] = attachment.media_type

    def _count(self, record: Record) -> None:
        chunk = Chunk.read(body_stream(record.body))
        for opcode, body in inner_records(chunk_bytes(record)):
            if opcode == Opcode.MESSAGE:
                message = raw_message(body)
                self._tallies[message.channel].add(message.log_time_ns)
            elif opcode == Opcode.SCHEMA:
                schema = Schema.read(body_stream(body))
                self._schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(body_stream(body))
                self._channels[channel.id] = channel
                if channel.id not in self._tallies:
                    schema_of = self._schemas.get(channel.schema_id)
                    self._tallies[channel.id] = _Tally(channel.topic, "" if schema_of is None else schema_of.name)
        self.chunks.append(ChunkPlace(record.offset, chunk.message_start_time, chunk.message_end_time))


def _check_crc(written: int, calculated: int) -> None:
    # Zero says that the writer made no checksum.
    if written not in (0, calculated):
        raise ValueError(f"the checksum is {calculated:#010x}, written was {written:#010x}")


def _check_version(path: str, text: str) -> None:
    if not _VERSION.fullmatch(text):
        shown = text if len(text) <= 20 else f"{text[:20]}..."
        raise LogError(f"has the schema version {shown!r} in its metadata; a whole number is expected", where=path)
    if int(text) > SCHEMA_VERSION:
        raise LogError(
            f"has the schema version {text}; this waypointctl reads up to {SCHEMA_VERSION}",
            where=path,
            mend="It was written by a newer waypointctl: install that one.",
        )
