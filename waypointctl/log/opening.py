"""The file of a log: opened, checked, how much of it is read, and the errors for one that is damaged (docs/limits.md).

Everything is counted before memory is taken for it. A few kilobytes of a compressed file can unpack to gigabytes, so
what unpacking gives is bounded by the size of the file: a log of a flight of days is large, and may unpack to more.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import IO, Final

from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from zstandard import ZstdError

from waypointctl.display_text import shell_word
from waypointctl.errors import LogError
from waypointctl.input_file import NOT_THERE, open_input
from waypointctl.limits import LIMITS, limit, limit_hint
from waypointctl.mission.file_kind import FileKind, is_lfs_pointer
from waypointctl.paths import command_for_mission, command_for_plan

MAGIC: Final = b"\x89MCAP0\r\n"
# What mcap, zstd and protobuf raise over bytes that are not what they should be.
DAMAGE = (struct.error, ValueError, KeyError, MemoryError, OverflowError, McapError, ZstdError, DecodeError)
PART: Final = ".part"  # of the name of a log that is being written
_LOOK_BYTES: Final = 100  # of what is not a log, to see what it is


def open_file(path: Path) -> IO[bytes]:
    """Open a log for reading.

    Raises:
        LogError: it is missing, not a regular file, or cannot be read.
    """
    if path.is_dir():
        raise LogError("is a folder; a log is one .mcap file", where=str(path))
    try:
        return open_input(path, LogError)
    except LogError as error:
        problem = "no such log" if error.problem == NOT_THERE else error.problem
        raise LogError(problem, where=str(path)) from None


def damaged(path: str, offset: int, what: str) -> LogError:
    """Return the error for a file whose bytes are not those that were written."""
    return LogError(
        f"is damaged at byte {offset}: {what}",
        where=path,
        hint="The file is not as it was written: use another copy of it.",
    )


def check_magic(stream: IO[bytes], path: Path, size: int) -> None:
    """Raise LogError unless a file of `size` bytes begins as MCAP does."""
    if path.suffix == PART and size < len(MAGIC) and MAGIC.startswith(stream.read(size)):
        raise nothing_flown(path)
    if size == 0:
        raise LogError("is empty", where=str(path))
    if (beginning := stream.read(len(MAGIC))) != MAGIC:
        if is_lfs_pointer(beginning + stream.read(_LOOK_BYTES)):
            raise LogError(FileKind.LFS_POINTER.value, where=str(path))
        hint = command_for_mission(str(path)) or command_for_plan(str(path)) or "a log is what `waypointctl run` writes"
        raise LogError("is not an MCAP file", where=str(path), hint=f"{hint[0].upper()}{hint[1:]}.")


def nothing_flown(path: Path) -> LogError:
    """Return the error for a .part that has nothing in it yet."""
    return LogError(
        "has no messages: its flight was killed before it started, or is just starting",
        where=str(path),
        hint=f"Run the mission again: `waypointctl run MISSION.yaml --out {shell_word(str(path.with_suffix('')))} "
        "--force`.",
    )


FREE_BYTES: Final = 2**26  # that all chunks together may unpack to, whatever the file's size
_LEAST_ATTACHMENT: Final = 45  # [bytes] of an attachment's record without its name and content
_LEAST_ENTRY: Final = 4  # [bytes] of an entry: the length of its name
INDEX_BYTES: Final = 16  # in the file for each message: its entry in the index of its chunk


class OverLimit(ValueError):
    """There is more of something than is read."""

    def __init__(self, name: str, what: str, found: int, enough: int = 0) -> None:
        """Say of what there are `found`, or more, but at most `enough` if it is given; and which limit that is over."""
        super().__init__(f"has at least {found:,} {what}; the limit {name} is {LIMITS[name].text(limit(name))}")
        self._hint = limit_hint(name, max(found, enough))

    def refusal(self, path: str) -> LogError:
        """Return the error for the log at `path`."""
        return LogError(str(self), where=path, hint=self._hint)


class Bounds:
    """Counts what is read of one log.

    Raises:
        OverLimit: in each `take_...`: there is more than the limit.
    """

    def __init__(self, file_bytes: int) -> None:
        """Begin with a file of this size, of which nothing has been read."""
        self._file_bytes = file_bytes
        self._attachments = self._attached = self._entries = self._described = self._unpacked = self._messages = 0

    def take_attachment(self, size: int) -> None:
        """Count an attachment of this many bytes."""
        self._attachments += 1
        self._attached += size
        _require("log-entries", self._attachments, "attachments", self._file_bytes // _LEAST_ATTACHMENT)
        _require("log-attachments", self._attached, "bytes of attachments", self._file_bytes)

    def take_description(self, size: int) -> None:
        """Count a metadata record, a schema or a channel of this many bytes."""
        self._described += size
        enough = max(self._file_bytes, self._unpacked)
        _require("log-metadata", self._described, "bytes of metadata, schemas and channels", enough)

    def take_entries(self, count: int) -> None:
        """Count entries of metadata, schemas or channels."""
        self._entries += count
        enough = max(self._file_bytes, self._unpacked) // _LEAST_ENTRY
        _require("log-entries", self._entries, "entries of metadata, schemas and channels", enough)

    def take_chunk(self, unpacked: int) -> None:
        """Count a chunk that declares to unpack to this many bytes."""
        _require("log-chunk", unpacked, "bytes in one chunk")
        self._unpacked += unpacked
        beyond = max(0, self._unpacked - FREE_BYTES)
        _require("log-expansion", -(-beyond // self._file_bytes), "times as many bytes in chunks as in the file")

    def take_messages(self, count: int) -> None:
        """Count messages."""
        self._messages += count
        beyond = self._messages - self._file_bytes // INDEX_BYTES
        _require("log-messages", beyond, "messages more than its file has room for an index of")


def _require(name: str, found: int, what: str, enough: int = 0) -> None:
    if found > limit(name):
        raise OverLimit(name, what, found, enough)
