"""Reading a user-given file: a regular file, within its folder where it belongs to one, of a bounded size.

A pipe or a device could keep the program waiting, or never end; a link that leads out of a folder would take a file
into a log, or into a message, that the user did not mean to give.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import IO, Final

from waypointctl.errors import InputError
from waypointctl.limits import limit, limit_hint, over_limit, size_text

_KINDS: Final = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}
_PIPE_MEND: Final = "write what comes out of it into a file, and give that"
_FLAGS: Final = os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK  # opening a pipe does not block
RECORD_FILE: Final = 2**24  # [bytes] that a file of results, or of what a training has recorded, may have
NOT_THERE: Final = "there is no such file"  # the problem of a file that is not there


def open_input(path: Path, error: type[InputError] = InputError, *, within: Path | None = None) -> IO[bytes]:
    """Open a regular file for reading.

    Args:
        path: of the file; it may be a link to one.
        error: the type of what is raised.
        within: the folder that a link must not lead out of; None where the user named the file.

    Raises:
        InputError: of the type `error`: it does not exist, cannot be read, is not a regular file, or lies elsewhere.
    """
    try:
        real = os.path.realpath(path)
        if within is not None and not Path(real).is_relative_to(os.path.realpath(within)):
            problem = f"is a link that leads out of the folder {str(within)!r}"
            raise error(problem, where=str(path), hint="put the file itself there")
        file = os.fdopen(os.open(path if within is None else real, _FLAGS), "rb")
    except FileNotFoundError:
        raise error(NOT_THERE, where=str(path)) from None
    except OSError as reason:
        # What cannot be opened, such as a socket, is reported by its kind too.
        raise error(_kind(path) or f"cannot be read: {reason.strerror}", where=str(path)) from reason
    except ValueError as reason:  # a name with a zero byte
        raise error(f"cannot be read: {reason}", where=str(path)) from reason
    if fault := _other_kind(os.fstat(file.fileno()).st_mode):
        is_pipe = stat.S_ISFIFO(os.fstat(file.fileno()).st_mode)
        file.close()
        raise error(fault, where=str(path), hint=_PIPE_MEND if is_pipe else None)
    return file


def read_input(
    path: Path,
    most: int | str,
    error: type[InputError] = InputError,
    *,
    within: Path | None = None,
    hint: str | None = None,
    enough: int = 0,
) -> bytes:
    """Return the bytes of a regular file.

    Args:
        path: of the file.
        most: bytes that it may have, or the name of the limit that sets it.
        error: the type of what is raised.
        within: as for `open_input`.
        hint: what to do about a file that is larger; that of a named limit is known.
        enough: bytes that the limit has to allow for other files that are read with this one.

    Raises:
        InputError: of the type `error`: as for `open_input`, or it is larger.
    """
    allowed = limit(most) if isinstance(most, str) else most
    with open_input(path, error, within=within) as file:
        size = os.fstat(file.fileno()).st_size
        content = b"" if size > allowed else _read(file, allowed + 1, path, error)
    if (found := max(size, len(content))) > allowed:
        if isinstance(most, str):
            raise error(over_limit(most, found), where=str(path), hint=limit_hint(most, max(found, enough)))
        raise error(f"is larger than the {size_text(most)} that are read", where=str(path), hint=hint)
    return content


def read_start(path: Path, count: int, error: type[InputError] = InputError, *, within: Path | None = None) -> bytes:
    """Return the first `count` bytes of a regular file, or all that it has.

    Raises:
        InputError: of the type `error`: as for `open_input`.
    """
    with open_input(path, error, within=within) as file:
        return _read(file, count, path, error)


def _read(file: IO[bytes], count: int, path: Path, error: type[InputError]) -> bytes:
    try:
        return file.read(count)
    except OSError as reason:
        raise error(f"cannot be read: {reason.strerror}", where=str(path)) from reason


def _kind(path: Path) -> str | None:
    try:
        return _other_kind(os.stat(path).st_mode)
    except (OSError, ValueError):
        return None


def _other_kind(mode: int) -> str | None:
    """Return the problem text for a file that is not regular; None for one that is."""
    if stat.S_ISREG(mode):
        return None
    return f"is {_KINDS.get(stat.S_IFMT(mode), 'something else')}, not a file"
