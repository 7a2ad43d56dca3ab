"""The interface of the importers: what reads one format of another tool, the mission that it returns, its problems.

To add a format, write one file with an `Importer` and name it in conversion.py.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from waypointctl.display_text import shown
from waypointctl.errors import MissionError
from waypointctl.importers.local_frame import Place
from waypointctl.mission.file_kind import FileKind, kind_of

_MOST_SHOWN: Final = 20  # of the problems of a file
_MAX_LATITUDE: Final = 90.0
_MAX_LONGITUDE: Final = 360.0  # maps of the Moon and Mars count to 360, lines across the antimeridian beyond 180
_SCALED: Final = 1e7  # MAVLink's integers are degrees times this

MOST_STOPS: Final = 1000  # waypoints of a mission
MOST_POSITIONS: Final = 20_000  # of a line, which is thinned where it has more than a mission


@dataclass(slots=True)
class _Cause:
    text: str  # the first place that it was found at, and the problem
    last: str
    count: int = 1


@dataclass(slots=True)
class Report:
    """What is found in a file."""

    where: str  # the file, for messages
    left_out: Counter[str] = field(default_factory=Counter)  # what is left out of the mission, in words, and how often
    _causes: dict[str, _Cause] = field(default_factory=dict)

    @property
    def is_clean(self) -> bool:
        """Whether nothing was found wrong so far."""
        return not self._causes

    def add_problem(self, place: str, problem: str, cause: str | None = None) -> None:
        """Note a problem.

        Args:
            place: in the file, as "mission.items[3]"; empty for the file as a whole.
            problem: what is wrong there.
            cause: problems of one cause are reported once, with their number; the problem itself where it is left out.
        """
        text = f"{place}: {problem}" if place else problem
        known = self._causes.get(cause or problem)
        if known is None:
            self._causes[cause or problem] = _Cause(text, place)
        elif known.last != place:  # one value may be looked at for several reasons
            known.last, known.count = place, known.count + 1

    def refuse(self) -> None:
        """Refuse the file if anything is wrong with it.

        Raises:
            MissionError: with all of it, a line for each cause.
        """
        if not self._causes:
            return
        texts = [_with_count(cause) for cause in self._causes.values()]
        if len(texts) == 1:
            raise MissionError(texts[0], where=self.where)
        details = [f"{self.where}: {text}" for text in texts[:_MOST_SHOWN]]
        if len(texts) > _MOST_SHOWN:
            details.append(f"{self.where}: and {len(texts) - _MOST_SHOWN} more")
        raise MissionError(f"{len(texts)} problems", where=self.where, details=details)

    def place(self, at: str, latitude: object, longitude: object, order: str = "") -> Place | None:
        """Return a place [deg], None where it is none, which is reported.

        Args:
            at: the place in the file.
            latitude: a number, or text of one.
            longitude: the same.
            order: how the file's format writes a place, where it is easily written the other way round.
        """
        north, east = number_of(latitude), number_of(longitude)
        if north is None or east is None:
            wrong = latitude if north is None else longitude
            if wrong == "":
                self.add_problem(at, f"the {'latitude' if north is None else 'longitude'} is missing", "missing")
                return None
            self.add_problem(at, f"{shown(wrong)} is not a finite number of degrees", "not a number of degrees")
        elif abs(north) > _MAX_LATITUDE or abs(east) > _MAX_LONGITUDE:
            problem = (
                f"{north:.10g}, {east:.10g} is not a latitude within -{_MAX_LATITUDE:g} and {_MAX_LATITUDE:g} and a "
                f"longitude within -{_MAX_LONGITUDE:g} and {_MAX_LONGITUDE:g} [deg]"
            )
            if abs(north) <= 90 * _SCALED and abs(east) <= 180 * _SCALED and max(abs(north), abs(east)) >= _SCALED:
                problem += "; they look like degrees times 10^7"
            elif max(abs(north), abs(east)) > _MAX_LONGITUDE:
                problem += "; they look like metres of a projection"
            elif abs(east) <= 90 < abs(north):
                problem += f"; they look swapped{order and f': {order}'}"
            self.add_problem(at, problem, "not a place")
        else:
            return north, east
        return None


def text_of(source: bytes, report: Report) -> str:
    """Return UTF-8 text, with or without a byte order mark.

    Raises:
        MissionError: it is not UTF-8, or is empty.
    """
    try:
        text = source.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = source.count(b"\n", 0, error.start) + 1
        problem = f"is not UTF-8 text: byte 0x{source[error.start]:02x}"
        raise MissionError(problem, where=f"{report.where}:{line}") from error
    if not text.strip():
        raise MissionError("is empty", where=report.where)
    return text


def number_of(value: object) -> float | None:
    """Return a finite number that a file holds as a number or as text, None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    if isinstance(value, str) and "_" in value:  # Python reads 1_0 as 10
        return None
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return None
    return number if math.isfinite(number) else None


def _with_count(cause: _Cause) -> str:
    others = cause.count - 1
    if not others:
        return cause.text
    return f"{cause.text} (and {others:,} more of the kind, the last {'is' if others == 1 else 'at'} {cause.last})"


@dataclass(frozen=True, slots=True)
class Stop:
    """A place to go to."""

    place: Place | None  # latitude and longitude [deg], or x and y [m]; None: where the robot starts
    name: str = ""  # empty for none
    at: str = ""  # position in the file, for messages
    hold_s: float = 0.0  # how long to stay there
    radius_m: float | None = None  # how near is there; None for the mission's default
    observe: bool = False  # whether a picture is taken there
    needs_way: bool = False  # whether it is a stop only where the robot is elsewhere before it


@dataclass(frozen=True, slots=True)
class Zone:
    """An area of a fence: a circle with a centre and a radius, or a polygon with corners."""

    keep_in: bool
    corners: tuple[Place, ...]  # of a circle its centre alone
    radius_m: float | None = None
    at: str = ""  # position in the file, for messages


@dataclass(frozen=True, slots=True)
class ImportedMission:
    """A file's mission, in the file's own coordinates."""

    start: Place | None  # where the robot starts; None where the file does not give it
    stops: tuple[Stop, ...]  # the places to go to, in order
    name: str = ""  # of the mission; empty where the file gives none
    start_at: str = ""  # position of the start in the file, for messages
    is_home: bool = False  # whether the start is a home beside the path, and not the path's own beginning
    zones: tuple[Zone, ...] = ()  # of the fence; the robot is to be in each one that is to be kept in
    return_to: Place | None = None  # where the robot goes when it breaks the fence; None: it holds
    left_out: tuple[str, ...] = ()  # other content of the file
    remarks: tuple[str, ...] = ()  # what else the user should know
    order: str = ""  # how the file's format writes a place, where it is easily written the other way round
    body: str = "earth"  # that the places are on, by its name in local_frame.BODIES
    # Whether the stops are places along a line, of which some can be dropped, and not places to stop at
    is_line: bool = False
    is_metric: bool = False  # whether places are x and y [m] instead of latitude and longitude [deg]


@dataclass(frozen=True, slots=True)
class Importer:
    """Reads one format."""

    name: str  # of the format, with its article where it needs one
    suffixes: tuple[str, ...]  # of files in it, in lower case
    recognises: Callable[[bytes], bool]  # whether a file is in it, by its content
    # Returns the mission. What is wrong with the file, or cannot be done by a robot on the ground, and what is
    # left out, goes into the report; where nothing can be read on, it raises MissionError
    read: Callable[[bytes, Report], ImportedMission]


def of_kind(kind: FileKind) -> Callable[[bytes], bool]:
    """Return a predicate for files of a kind."""
    return lambda source: kind_of(source) is kind
