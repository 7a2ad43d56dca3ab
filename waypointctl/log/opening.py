"""The file of a log: opened, checked, and the errors for one that is damaged."""

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
from waypointctl.log.records import MAGIC
from waypointctl.mission.file_kind import FileKind, is_lfs_pointer
from waypointctl.paths import command_for_mission, command_for_plan

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
