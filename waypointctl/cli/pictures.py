"""What is said of a flight's pictures, and where they are written."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

from waypointctl.display_text import printable

if TYPE_CHECKING:
    from waypointctl.flight.outcome import FlightResult
    from waypointctl.log.reader import LogReader
    from waypointctl.replay.pictures import PictureFile

_PNG: Final = b"\x89PNG"


def say_missing(result: FlightResult) -> None:
    """Say on stderr why a flight that observed has no pictures, if that is so."""
    if result.no_pictures:
        print(f"no pictures: {printable(result.no_pictures)}", file=sys.stderr, flush=True)


def picture_files(log: LogReader, folder: Path) -> list[PictureFile]:
    """Return a log's pictures for a folder that they can be written to.

    Raises:
        OutputError: the folder cannot be written, or a name is taken by a file that is not a picture.
    """
    from waypointctl.paths import refuse_other_content, refuse_unwritable_folder
    from waypointctl.replay.pictures import pictures_in

    refuse_unwritable_folder(folder)
    files = pictures_in(log)
    for file in files:
        refuse_other_content(folder / file.name, _PNG, "a PNG")
    return files


def write_pictures(files: list[PictureFile], folder: Path) -> None:
    """Write pictures into a folder, which is made if need be, and say so.

    Raises:
        OutputError: they cannot be written.
    """
    from waypointctl.errors import OutputError
    from waypointctl.paths import write_whole

    if not files:
        why = "there was no observation, or no renderer was available"
        print(f"the log has no pictures: {why}", file=sys.stderr)
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder cannot be made: {error.strerror}", where=str(folder)) from error
    for file in files:
        write_whole(folder / file.name, file.data, "the picture")
        print(f"written: {printable(folder / file.name)}", file=sys.stderr)
