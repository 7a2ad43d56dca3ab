"""The pictures of a flight as files, each named for the waypoint that was observed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from waypointctl.log.messages import Picture
from waypointctl.log.png import TITLE, texts_of
from waypointctl.log.reader import LogReader

_UNSAFE: Final = re.compile(r"[^\w.-]+")
_LONGEST: Final = 150  # bytes of a name; a file's may have 255, and some are for its number and for writing it


@dataclass(frozen=True, slots=True)
class PictureFile:
    """A picture to be written."""

    name: str  # of the file: its number in the flight, and the waypoint's name where it is safe
    data: bytes


def pictures_in(log: LogReader) -> list[PictureFile]:
    """Return the pictures of a log in the order in which they were taken.

    Raises:
        LogError: a message cannot be read.
    """
    pictures = [message for message in log.messages(("/camera",)) if isinstance(message, Picture)]
    return [PictureFile(name, picture.data) for name, picture in zip(names_of(pictures), pictures, strict=True)]


def names_of(pictures: Sequence[Picture]) -> list[str]:
    """Return the name of each picture's file: its number, and what it shows."""
    digits = max(2, len(str(len(pictures))))
    return [
        f"{number:0{digits}}-{_safe(_title(picture))}.{_safe(picture.format)}"
        for number, picture in enumerate(pictures, 1)
    ]


def _title(picture: Picture) -> str:
    try:
        return texts_of(picture.data).get(TITLE, "")
    except ValueError:
        return "damaged"  # verification reports the error


def _safe(text: str) -> str:
    name = _UNSAFE.sub("-", text).strip("-.").encode()[:_LONGEST]
    return name.decode(errors="ignore") or "picture"
