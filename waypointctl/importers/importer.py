"""The interface of the importers: what reads one format of another tool, and the mission that it returns.

To add a format, write one file with an `Importer` and name it in registry.py.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from waypointctl.importers.local_frame import Place
from waypointctl.mission.file_kind import FileKind, kind_of

MOST_STOPS: Final = 1000  # waypoints of a mission
MOST_POSITIONS: Final = 20_000  # of a line, which is thinned where it has more than a mission


@dataclass(frozen=True, slots=True)
class Stop:
    """A place to go to.

    Attributes:
        place: latitude and longitude [deg], or x and y [m]; None: where the robot starts.
        name: empty for none.
        at: position in the file, for messages.
        hold_s: how long to stay there.
        radius_m: how near is there; None for the mission's default.
        observe: whether a picture is taken there.
        needs_way: whether it is a stop only where the robot is elsewhere before it.
    """

    place: Place | None
    name: str = ""
    at: str = ""
    hold_s: float = 0.0
    radius_m: float | None = None
    observe: bool = False
    needs_way: bool = False


@dataclass(frozen=True, slots=True)
class Zone:
    """An area of a fence: a circle with a centre and a radius, or a polygon with corners."""

    keep_in: bool
    corners: tuple[Place, ...]  # of a circle its centre alone
    radius_m: float | None = None
    at: str = ""  # position in the file, for messages


@dataclass(frozen=True, slots=True)
class ImportedMission:
    """A file's mission, in the file's own coordinates.

    Attributes:
        name: of the mission.
        start: where the robot starts; None where the file does not give it.
        stops: the places to go to, in order.
        start_at: position of the start in the file, for messages.
        is_home: whether the start is a home beside the path, and not the path's own beginning.
        zones: of the fence; the robot is to be in each one that is to be kept in.
        return_to: where the robot goes when it breaks the fence; None: it holds.
        left_out: other content of the file.
        remarks: what else the user should know.
        order: how the file's format writes a place, where it is easily written the other way round.
        body: that the places are on, by its name in local_frame.BODIES.
        is_line: whether the stops are places along a line, of which some can be dropped, and not places to stop at.
        is_metric: whether places are x and y [m] instead of latitude and longitude [deg].
    """

    name: str
    start: Place | None
    stops: tuple[Stop, ...]
    start_at: str = ""
    is_home: bool = False
    zones: tuple[Zone, ...] = ()
    return_to: Place | None = None
    left_out: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    order: str = ""
    body: str = "earth"
    is_line: bool = False
    is_metric: bool = False


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """What an importer is given beside the file's bytes."""

    where: str  # the file, for messages
    name: str  # of the mission, where the file gives none


@dataclass(frozen=True, slots=True)
class Importer:
    """Reads one format.

    Attributes:
        name: of the format, with its article where it needs one.
        suffixes: of files in it, in lower case.
        recognises: whether a file is in it, by its content.
        read: returns the mission; raises MissionError with everything that is wrong with the file, or that cannot be
            done by a robot on the ground.
    """

    name: str
    suffixes: tuple[str, ...]
    recognises: Callable[[bytes], bool]
    read: Callable[[bytes, ImportOptions], ImportedMission]


def mission_name(text: str) -> str:
    """Return a text as a mission's name, which names files."""
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", text)[:80].strip("-._")
    return name or "imported"


def of_kind(kind: FileKind) -> Callable[[bytes], bool]:
    """Return a predicate for files of a kind."""
    return lambda source: kind_of(source) is kind
