"""Checking and writing user-given paths without a traceback: a name can be too long to be looked up."""

from __future__ import annotations

import fcntl
import os
import stat
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO, Final

from waypointctl.display_text import shell_word
from waypointctl.errors import OutputError

_FILE_MEND: Final = "give a path in a writable folder"
MCAP: Final = b"\x89MCAP0\r\n"  # what a log begins with
PNG: Final = b"\x89PNG\r\n\x1a\n"

_FOLDER_MEND: Final = "Give a path in a writable folder."
_PLANS: Final = {
    ".plan": "a QGroundControl plan",
    ".waypoints": "a waypoint file",
    ".geojson": "a GeoJSON file",
    ".gpx": "a GPX file",
    ".kml": "a KML file",
    ".csv": "a CSV file",
}


def folder_fault(path: Path) -> str | None:
    """Return why a path is not a readable folder, None if it is one."""
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return "folder not found"
    except (OSError, ValueError) as error:
        return f"cannot be read: {getattr(error, 'strerror', None) or error}"
    return None if stat.S_ISDIR(mode) else f"is {'a file, ' * stat.S_ISREG(mode)}not a folder"


def command_for_log(path: str) -> str:
    """Return the problem text for a log that was given for something else."""
    log = shell_word(path)
    return f"this is a log: `waypointctl replay {log}` shows it, `waypointctl run --resume {log}` continues it"


def command_for_plan(path: str) -> str:
    """Return the problem text for another tool's plan given as a mission or log; empty for any other file."""
    plan = Path(path)
    kind = _PLANS.get(plan.suffix.lower())
    if kind is None:
        return ""
    there = shell_word(plan.with_suffix(".yaml").name)
    return f"this is {kind}; import it first: `waypointctl import {shell_word(path)} --out {there}`"


def command_for_mission(path: str) -> str:
    """Return the problem text for a mission given as a log; empty for a file without its suffix."""
    if Path(path).suffix.lower() not in (".yaml", ".yml"):
        return ""
    mission = shell_word(path)
    return f"`waypointctl run {mission}` flies a mission and writes its log, `waypointctl validate {mission}` checks it"


def lock(stream: IO[bytes]) -> bool:
    """Lock an open file until it is closed, however the process ends; return False if it is locked already.

    Where the file system knows no locks, everybody gets one.
    """
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def is_being_written(path: Path) -> bool:
    """Return whether a flight under way holds the file's lock; a file that cannot be opened is not held."""
    try:
        with path.open("rb") as file:
            return not lock(file)
    except OSError:
        return False


def refuse_unwritable_file(path: Path, what: str) -> None:
    """Refuse a file that could not be written, before the work that it is for.

    Tried with an empty file beside it, removed at once: permissions alone do not show a read-only
    or full disk, nor of /proc.

    Args:
        path: of the file, which may be there already.
        what: goes into it, for the message: "the picture".

    Raises:
        OutputError: it is a folder, its name cannot be, or the folder it is to be in is none or is read-only.
    """
    folder = path.parent
    try:
        if path.is_dir():
            fault = "this is a folder"
        elif not folder.is_dir():
            fault = f"{str(folder)!r} is not a folder" if folder.exists() else f"the folder {folder} does not exist"
        elif path.exists() and not os.access(path, os.W_OK):
            fault = "no permission"
        elif _is_standard_stream(path):
            fault = "standard output or error goes into this very file, and would be lost"
        elif path.is_file() and is_being_written(path):
            fault = "a flight under way is writing this file"
        elif path.exists() and not path.is_file():  # a device is written as it is
            return
        else:
            part = _part(path)
            trial = _trial_fault(part.parent, part.touch, part.unlink)
            if trial is None:
                return
            fault = trial
    except OSError as error:
        fault = str(error.strerror)
    raise OutputError(f"{what} cannot be written: {fault}", where=str(path), hint=_FILE_MEND)


def write_fault(path: Path, error: OSError) -> str:
    """Return why a file could not be made, in words for the user: a missing or read-only folder is named."""
    folder = path.parent
    if isinstance(error, FileNotFoundError) and not folder.is_dir():
        return f"the folder {folder} does not exist"
    if isinstance(error, FileNotFoundError | PermissionError) and not path.exists():
        nearest = next((each for each in (folder, *folder.parents) if each.exists()), folder)
        return f"the folder {nearest} is not writable"
    return str(error.strerror)


def write_whole(path: Path, content: bytes, what: str) -> None:
    """Write a file under another name beside it and move it into place: `path` never has half of it.

    What is not a regular file, such as a pipe, is written directly. Where `path` is a link, the file it
    leads to is replaced.

    Args:
        path: of the file; what is there is replaced.
        content: all of it.
        what: it is, for the message: "the picture".

    Raises:
        OutputError: it cannot be written; what was there before still is.
    """
    part = _part(path)
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(content)
            return
        part.write_bytes(content)
        part.replace(os.path.realpath(path))
    except OSError as error:
        with suppress(OSError):  # the name can be too long even to be removed
            part.unlink(missing_ok=True)
        problem = f"{what} cannot be written: {write_fault(path, error)}"
        raise OutputError(problem, where=str(path), hint=_FILE_MEND) from error


def open_lock(path: Path) -> IO[str]:
    """Open a file to be locked, making it if it is not there; what a link leads to is left alone.

    Raises:
        OSError: it cannot be made, or is a link or a pipe.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
    return os.fdopen(os.open(path, flags, 0o666), "w")


def refuse_other_content(path: Path, magic: bytes, kind: str) -> None:
    """Refuse to replace what is there unless it is an empty file, or one of the kind that is to be written.

    Args:
        path: of the file to write, which may be there already.
        magic: what a file of the kind begins with.
        kind: for the message: "a PNG".

    Raises:
        OutputError: it is something else, such as the input itself, or is not a regular file, such as a device.
    """
    try:
        if not path.exists():
            return
        # Reading from a device or a pipe could block for ever.
        if not path.is_file():
            fault = f"is not a regular file, and {kind} would take its place"
        elif begins(path, magic):
            return
        else:
            fault = f"already exists and is not {kind}"
    except OSError as error:
        fault = f"cannot be read, to see whether it is {kind}: {error.strerror}"
    raise OutputError(fault, where=str(path), hint="Name another file.")


def begins(path: Path, magic: bytes) -> bool:
    """Return whether a regular file is empty or begins with these bytes."""
    with path.open("rb") as file:
        return file.read(len(magic)) in (b"", magic)


def refuse_unwritable_folder(folder: Path) -> None:
    """Refuse a folder that cannot be made or written, before there is anything to write.

    Tried with an empty folder, removed at once: permissions alone do not show a read-only or full
    disk, nor of /proc.

    Raises:
        OutputError: it, or what it would be made in, is not a folder or is read-only, or its name is not possible.
    """
    try:
        nearest = next(path for path in (folder, *folder.parents) if path.exists())
    except OSError as error:
        problem = f"the folder cannot be created: {error.strerror}"
        raise OutputError(problem, where=str(folder), hint=_FOLDER_MEND) from error
    if not nearest.is_dir():
        problem = "this is a file" if nearest == folder else f"{str(nearest)!r} is a file"
    else:
        trial = nearest / f".{folder.name}.{os.getpid()}.tmp"  # as what is written is staged under
        fault = _trial_fault(nearest, trial.mkdir, trial.rmdir)
        if fault is None:
            return
        problem = fault
    raise OutputError(f"the folder cannot be written: {problem}", where=str(folder), hint=_FOLDER_MEND)


def _part(path: Path) -> Path:
    """Return the name that a file is written under before it is moved into place: beside it, where a link leads."""
    real = Path(os.path.realpath(path))
    return real.with_name(f".{real.name}.{os.getpid()}.tmp")


def _is_standard_stream(path: Path) -> bool:
    """Tell whether a regular file is the one that this program's own output goes into, as with `> file`."""
    for descriptor in (1, 2):
        with suppress(OSError):
            if path.is_file() and os.path.samestat(path.stat(), os.fstat(descriptor)):
                return True
    return False


def _trial_fault(folder: Path, make: Callable[[], None], remove: Callable[[], None]) -> str | None:
    """Return why a file or folder cannot be made in a folder, None if it could be and is removed again."""
    try:
        make()
        remove()
    except FileExistsError:
        return None  # another process's trial
    except (PermissionError, FileNotFoundError):  # the latter in /proc
        return f"the folder {folder} is not writable"
    except OSError as error:
        return str(error.strerror)
    return None
