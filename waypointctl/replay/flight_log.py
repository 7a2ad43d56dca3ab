"""A flight's log, read: its mission, its messages, its summary."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final, Self

from waypointctl.errors import MissionError, given_path
from waypointctl.flight.header import MISSION, MISSION_FOLDER, files_within, setting_of
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.log.header import MissionSetting
from waypointctl.log.messages import Event, EventKind, Picture, PlannedWaypoint
from waypointctl.log.opening import PART
from waypointctl.log.png import TITLE, texts_of
from waypointctl.log.reader import LogReader
from waypointctl.log.scan import scan
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.summary_builder import summarize


class FlightLog(LogReader):
    """The log of a flight: `messages()` and `arrays(topic)` of a LogReader, and the flight's mission and summary."""

    @classmethod
    def open(cls, path: Path | str, *, allow_truncated: bool = False) -> Self:
        """Check the whole file, every checksum of it, and return the log.

        Args:
            path: the .mcap file, or the .part of a flight that was killed or is under way.
            allow_truncated: read a file that is cut short, such as a .part, up to where it is whole.

        Raises:
            LogError: the file cannot be read, is damaged or cut short, is over a limit, is not a log of waypointctl, or
                has another schema version.
        """
        return cls(Path(path), scan(Path(path), allow_truncated=allow_truncated))

    @property
    def mission_name(self) -> str:
        """The name of the mission that was flown."""
        return self.metadata.get("mission") or self.path.stem

    @cached_property
    def mission(self) -> Mission | None:
        """The mission; None if the log has none that can be read; `verify` reports the error."""
        source = self.attachments.get(MISSION)
        if source is None:
            return None
        try:
            return parse_mission(source, f"{self.path}/{MISSION}", files_within(MISSION_FOLDER, self.attachments))
        except MissionError:
            return None

    @property
    def waypoints(self) -> tuple[PlannedWaypoint, ...]:
        """The mission's waypoints; none without a mission."""
        return () if self.mission is None else planned_waypoints(self.mission)

    @cached_property
    def setting(self) -> MissionSetting:
        """What the mission has fixed: home, zones, contact windows; nothing without a mission."""
        try:
            return MissionSetting() if self.mission is None else setting_of(self.mission)
        except MissionError:
            return MissionSetting()

    @cached_property
    def summary(self) -> FlightSummary:
        """The summary of the flight; without a mission, of the waypoints that were commanded.

        Raises:
            LogError: a message cannot be read.
        """
        return summarize(self.messages(), self.waypoints, self.setting)


def open_log(path: Path | str, *, allow_truncated: bool = False) -> FlightLog:
    """Check a log, every checksum of it, and return it; a .part is read up to where it is whole.

    Args:
        path: of the log.
        allow_truncated: read any file that is cut short up to where it is whole, not a .part alone.

    Raises:
        LogError: as for `FlightLog.open`.
        InputError: the argument is not a path.
    """
    path = given_path("path", path, "a log")
    return FlightLog.open(path, allow_truncated=allow_truncated or path.suffix == PART)


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


def why_no_pictures(log: FlightLog) -> str:
    """Return why a log has no pictures.

    Raises:
        LogError: a message cannot be read.
    """
    events = (message for message in log.messages(("/event",)) if isinstance(message, Event))
    if any(event.kind is EventKind.OBSERVATION_TAKEN for event in events):
        return "no renderer was available during the flight"
    if log.mission is not None and not any(leg.observe for leg in log.mission.legs()):
        return "no waypoint of this mission has `observe: true`"
    return "the flight ended before the first observation"


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
