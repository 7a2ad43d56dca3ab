"""Where a flight's log and pictures go."""

from __future__ import annotations

import itertools
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final

from waypointctl.display_text import printable
from waypointctl.errors import OutputError
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.reader import LogReader
from waypointctl.paths import (
    MCAP,
    PNG,
    begins,
    is_being_written,
    lock,
    refuse_other_content,
    refuse_unwritable_folder,
    write_fault,
    write_whole,
)
from waypointctl.replay.flight_log import FlightLog, PictureFile, pictures_in, why_no_pictures

FOLDER: Final = Path("logs")

_WAIT: Final = "Wait for its end, or give another --out."


@contextmanager
def claimed(mission: str, out: Path | None, *, force: bool) -> Iterator[Path]:
    """Yield the path of the new log; until it is written, a locked `.part` beside it keeps others away.

    Args:
        mission: its name, which is the log's default name: logs/<mission>.mcap, then -2, -3, ...
        out: the given path.
        force: replace a log that stands there; nothing but a log or an empty file is ever replaced, and no log that a
            flight under way is writing.

    Raises:
        OutputError: it cannot be written, already exists, or is being written.
    """
    try:
        path, claim = _free(mission) if out is None else _asked(out, force)
    except OSError as error:
        where = str(out or FOLDER / f"{mission}.mcap")
        problem = f"cannot be written: {write_fault(Path(where), error)}"
        raise OutputError(problem, where=where, hint=_hint(error)) from error
    part = _part(path)
    with claim:
        try:
            yield path
        finally:
            if _stands_at(claim, part) and part.stat().st_size == 0:
                part.unlink()


def _free(mission: str) -> tuple[Path, IO[bytes]]:
    FOLDER.mkdir(exist_ok=True)
    names = itertools.chain([mission], (f"{mission}-{number}" for number in itertools.count(2)))
    paths = (FOLDER / f"{name}.mcap" for name in names)
    claims = ((path, _claim(path)) for path in paths if not path.exists())
    return next((path, claim) for path, claim in claims if claim is not None)


def _asked(path: Path, force: bool) -> tuple[Path, IO[bytes]]:
    if path.is_dir():
        raise OutputError("is a folder; a log is a file", where=str(path), hint="Name the file, such as flight.mcap.")
    if path.exists() and not path.is_file():
        problem = "is not a regular file, and a log would take its place"
        raise OutputError(problem, where=str(path), hint="Name another file, such as flight.mcap.")
    for taken in (path, _part(path)):
        if taken.is_file() and is_being_written(taken):
            raise OutputError(f"another flight is writing it, into {taken}", where=str(path), hint=_WAIT)
    if path.exists() and not begins(path, MCAP):
        problem = "is not a log; --force replaces only logs" if force else "already exists, and is not a log"
        raise OutputError(problem, where=str(path), hint="Give another --out.")
    if path.exists() and not force:
        raise OutputError("already exists", where=str(path), hint="Use --force to replace it, or give another --out.")
    claim = _claim(path, replace=force)
    if claim is not None:
        return path, claim
    if force:
        problem = f"another flight has begun to write {_part(path)}, or it is not a regular file"
        raise OutputError(problem, where=str(path), hint=_WAIT)
    hint = "`waypointctl run --resume` continues it, --force replaces it; or give another --out."
    raise OutputError(f"{_part(path)} already exists: a flight was killed", where=str(path), hint=hint)


def _claim(path: Path, *, replace: bool = False) -> IO[bytes] | None:
    """Return the empty and locked `.part` of a log; None if somebody else has it, or it is not to be replaced."""
    part = _part(path)
    try:
        descriptor = os.open(part, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | (0 if replace else os.O_EXCL), 0o666)
    except FileExistsError:
        return None
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        return None
    claim = open(descriptor, "r+b")  # noqa: SIM115 the caller closes it
    if lock(claim) and _stands_at(claim, part):
        claim.truncate(0)
        return claim
    claim.close()
    return None


def _stands_at(claim: IO[bytes], part: Path) -> bool:
    """Return whether an open file is the one at a path: another process may have moved or removed it."""
    try:
        return os.path.samestat(os.fstat(claim.fileno()), part.stat())
    except OSError:
        return False


def _hint(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "Create the folder, or give another --out."
    return "Give another --out, in a writable folder."


def _part(path: Path) -> Path:
    # The name under which LogWriter writes until the flight is over.
    return path.with_name(f"{path.name}.part")


def say_missing(result: FlightResult) -> None:
    """Say on stderr why a flight that observed has no pictures, if that is so."""
    if result.no_pictures:
        print(f"no pictures: {printable(result.no_pictures)}", file=sys.stderr, flush=True)


def picture_files(log: LogReader, folder: Path) -> list[PictureFile]:
    """Return a log's pictures for a folder that they can be written to.

    Raises:
        OutputError: the folder cannot be written, or a name is taken by a file that is not a picture.
    """
    refuse_unwritable_folder(folder)
    files = pictures_in(log)
    for file in files:
        refuse_other_content(folder / file.name, PNG, "a PNG")
    return files


def write_pictures(files: list[PictureFile], folder: Path, log: FlightLog) -> None:
    """Write pictures into a folder, which is made if need be, and say so.

    Raises:
        OutputError: they cannot be written.
    """
    if not files:
        print(f"the log has no pictures: {why_no_pictures(log)}", file=sys.stderr)
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder cannot be made: {error.strerror}", where=str(folder)) from error
    for file in files:
        write_whole(folder / file.name, file.data, "the picture")
        print(f"written: {printable(folder / file.name)}", file=sys.stderr)
