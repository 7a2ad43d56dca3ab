"""Where a flight's log goes: a name that is free, or the one that was asked for, claimed before the flight."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from waypointctl.errors import OutputError
from waypointctl.paths import MCAP, begins

FOLDER: Final = Path("logs")


@contextmanager
def claimed(mission: str, out: Path | None, *, force: bool) -> Iterator[Path]:
    """Yield the path of the new log; until it is written, an empty `.part` beside it keeps others away.

    Args:
        mission: its name, which is the log's where none is asked for: logs/<mission>.mcap, then -2, -3, ...
        out: the path that is asked for.
        force: replace a log that stands there; nothing but a log or an empty file is ever replaced.

    Raises:
        OutputError: it cannot be written, or is there already.
    """
    try:
        path = _free(mission) if out is None else _asked(out, force)
    except OSError as error:
        where = str(out or FOLDER / f"{mission}.mcap")
        raise OutputError(f"cannot be written: {error.strerror}", where=where, mend=_mend(error)) from error
    part = _part(path)
    try:
        yield path
    finally:
        if part.exists() and part.stat().st_size == 0:
            part.unlink()


def _free(mission: str) -> Path:
    FOLDER.mkdir(exist_ok=True)
    names = itertools.chain([mission], (f"{mission}-{number}" for number in itertools.count(2)))
    paths = (FOLDER / f"{name}.mcap" for name in names)
    return next(path for path in paths if not path.exists() and _claim(path))


def _asked(path: Path, force: bool) -> Path:
    if path.is_dir():
        raise OutputError("is a folder; a log is a file", where=str(path), mend="Name the file, such as flight.mcap.")
    if path.exists() and not path.is_file():
        problem = "is not a regular file, and a log would take its place"
        raise OutputError(problem, where=str(path), mend="Name another file, such as flight.mcap.")
    if path.exists() and not begins(path, MCAP):
        problem = "is not a log; --force replaces only logs" if force else "is there already, and is not a log"
        raise OutputError(problem, where=str(path), mend="Give another --out.")
    if force:
        _part(path).unlink(missing_ok=True)
    elif path.exists():
        raise OutputError("is there already", where=str(path), mend="--force replaces it; or give another --out.")
    if not _claim(path):
        problem = f"{_part(path)} is there already: another flight is writing it, or one was killed"
        mend = (
            "`waypointctl run --resume` goes on with one that was killed, --force replaces it; or give another --out."
        )
        raise OutputError(problem, where=str(path), mend=mend)
    return path


def _claim(path: Path) -> bool:
    try:
        _part(path).touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def _mend(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "Create the folder, or give another --out."
    return "Give another --out, in a folder that you can write to."


def _part(path: Path) -> Path:
    # The name under which LogWriter writes until the flight is over.
    return path.with_name(f"{path.name}.part")
