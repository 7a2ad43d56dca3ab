"""What is wrong with a file that another tool wrote, one problem a cause, and what of it is left out."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Final

from waypointctl.display_text import shown
from waypointctl.errors import MissionError
from waypointctl.importers.local_frame import Place

_MOST_SHOWN: Final = 20  # of the problems of a file
_MAX_LATITUDE: Final = 90.0
_MAX_LONGITUDE: Final = 360.0  # maps of the Moon and Mars count to 360, lines across the antimeridian beyond 180
_SCALED: Final = 1e7  # MAVLink's integers are degrees times this


@dataclass(slots=True)
class _Cause:
    text: str  # the first place that it was found at, and the problem
    last: str
    count: int = 1


@dataclass(slots=True)
class Report:
    """What is found in a file.

    Attributes:
        where: the file, for messages.
        left_out: what is left out of the mission, in words, and how often.
        remarks: what else the user should know.
    """

    where: str
    left_out: Counter[str] = field(default_factory=Counter)
    remarks: list[str] = field(default_factory=list)
    _causes: dict[str, _Cause] = field(default_factory=dict)

    @property
    def is_clean(self) -> bool:
        """Whether nothing was found wrong so far."""
        return not self._causes

    @property
    def left_out_lines(self) -> tuple[str, ...]:
        """What is left out, each kind with its number."""
        return tuple(f"{count} x {what}" for what, count in self.left_out.items())

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
