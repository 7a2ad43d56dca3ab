"""CSV with named columns: latitude and longitude [deg], or x and y [m]; a row a place, the first the start.

Columns are apart by commas, semicolons or tabs. `name`, `hold` [s] and `tolerance` [m] are read too; lines that begin
with '#' are comments.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Final

from waypointctl.display_text import counted, shown
from waypointctl.errors import MissionError
from waypointctl.importers.importer import MOST_STOPS, ImportedMission, Importer, Report, Stop, number_of, text_of
from waypointctl.importers.local_frame import Place
from waypointctl.mission.fields import DAY_S, FURTHEST_M
from waypointctl.mission.file_kind import kind_of

# What a column is called, in small letters and without a unit at its end.
_COLUMNS: Final = {
    "latitude": ("lat", "latitude"),
    "longitude": ("lon", "lng", "long", "longitude"),
    "x": ("x", "east", "easting"),
    "y": ("y", "north", "northing"),
    "name": ("name", "label", "title"),
    "hold": ("hold",),
    "tolerance": ("tolerance",),
}
_COORDINATES: Final = (("latitude", "longitude"), ("x", "y"))
_UNIT: Final = re.compile(r"(?:[\s_]+|[\s_]*[(\[])(?:deg|degrees|°|m|s)[)\]]?$")
_COMMENT: Final = re.compile(r"#|sep=.$")  # Excel takes a first line "sep=;" for the delimiter, and not for data
_MOST_COLUMNS: Final = 1000
_MOST_HEADER: Final = 1000  # characters that are looked at to see whether it is one
_DELIMITERS: Final = ",;\t"
_MOST_TOLERANCE_M: Final = 100.0


def is_table(source: bytes) -> bool:
    """Tell whether a text begins with a row of column names, two of which are coordinates."""
    if kind_of(source) is not None:
        return False
    text = source.decode("utf-8-sig", errors="replace")
    header = next((line for line in text.splitlines() if line.strip() and not _COMMENT.match(line)), "")[:_MOST_HEADER]
    columns = _columns(next(csv.reader([header], delimiter=_delimiter(header)), []))
    return any(set(keys) <= columns.keys() for keys in _COORDINATES)


def _read(source: bytes, report: Report) -> ImportedMission:
    header, rows, delimiter = _rows(text_of(source, report), report)
    if len(header) > _MOST_COLUMNS:
        raise MissionError(f"has {len(header):,} columns; at most {_MOST_COLUMNS:,} are read", where=report.where)
    table = _Table(_columns(header), len(header), delimiter, report)
    if table.keys is None:
        found = f"the columns {', '.join(map(shown, header[:12]))}" if header else "no columns"
        problem = f"has {found}; 'lat' and 'lon' [deg] or 'x' and 'y' [m] are needed"
        raise MissionError(problem, where=f"{report.where}:1")
    if not 2 <= len(rows) <= MOST_STOPS + 1:
        count = f"more than {MOST_STOPS + 1:,} rows" if len(rows) > MOST_STOPS else counted(len(rows), "rows")
        problem = f"has {count}; 2 to {MOST_STOPS + 1:,} are allowed: the start and the waypoints"
        raise MissionError(problem, where=report.where)
    start, *stops = [table.stop(number, row) for number, row in rows]
    report.refuse()
    assert start is not None
    read = set(table.keys) | set(table.columns) & {"name", "hold", "tolerance"}
    unread = [title for place, title in enumerate(header) if place not in {table.columns[key] for key in read}]
    is_metric = table.keys == ("x", "y")
    is_bare = is_metric and {header[table.columns[key]].strip().lower() for key in ("x", "y")} == {"x", "y"}
    return ImportedMission(
        start.place,
        tuple(stop for stop in stops if stop is not None),
        start_at=start.at,
        left_out=tuple(f"column {shown(title)}" for title in unread if title.strip()),
        remarks=("has x and y without a unit: they are read as metres",) if is_bare else (),
        is_metric=is_metric,
    )


def _rows(text: str, report: Report) -> tuple[list[str], list[tuple[int, list[str]]], str]:
    """Return the first row, the others with the numbers of their lines, as many as may be, and the delimiter."""
    lines = ["" if _COMMENT.match(line) else line for line in text.splitlines()]
    delimiter = _delimiter(next((line for line in lines if line.strip()), ""))
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
    rows = ((reader.line_num, row) for row in reader if any(map(str.strip, row)))
    try:
        _, header = next(rows, (1, []))
        return header, list(islice(rows, MOST_STOPS + 2)), delimiter
    except csv.Error as error:
        raise MissionError(f"is not CSV: {error}", where=f"{report.where}:{reader.line_num}") from error


@dataclass(frozen=True, slots=True)
class _Table:
    columns: Mapping[str, int]
    width: int
    delimiter: str
    report: Report

    @property
    def keys(self) -> tuple[str, str] | None:
        """The two columns of coordinates."""
        return next((keys for keys in _COORDINATES if set(keys) <= self.columns.keys()), None)

    def stop(self, number: int, row: list[str]) -> Stop | None:
        """Return the place of a row, None where it is none, which is reported."""
        at = f"line {number}"
        assert self.keys is not None
        if len(row) != self.width:
            problem = f"has {counted(len(row), 'values')}; the first line names {counted(self.width, 'columns')}"
            self.report.add_problem(at, problem, "number of values")
            return None
        one, other = (self._text(row, key) for key in self.keys)
        place = self.report.place(at, one, other) if self.keys[0] == "latitude" else self._point(at, one, other)
        hold_s = self._number(at, row, "hold", DAY_S)
        radius_m = self._number(at, row, "tolerance", _MOST_TOLERANCE_M)
        if place is None:
            return None
        return Stop(place, self._text(row, "name"), at, hold_s, radius_m or None)

    def _point(self, at: str, x: str, y: str) -> Place | None:
        x_m, y_m = number_of(x), number_of(y)
        if x_m is None or y_m is None:
            self.report.add_problem(at, f"{shown(x if x_m is None else y)} is not a number of metres", "not metres")
        elif max(abs(x_m), abs(y_m)) > FURTHEST_M:
            problem = f"({x_m:.10g}, {y_m:.10g}) is not within {FURTHEST_M:g} m of (0, 0)"
            self.report.add_problem(at, problem, "too far")
        else:
            return x_m, y_m
        return None

    def _number(self, at: str, row: list[str], key: str, most: float) -> float:
        text = self._text(row, key)
        number = number_of(text) if text else 0.0
        if number is not None and 0 <= number <= most:
            return number
        self.report.add_problem(at, f"{key} {shown(text)} is not a number within 0 and {most:g}", key)
        return 0.0

    def _text(self, row: list[str], key: str) -> str:
        text = row[self.columns[key]].strip() if key in self.columns else ""
        is_decimal_comma = key in ("latitude", "longitude") or (self.delimiter != "," and key != "name")
        return text.replace(",", ".") if is_decimal_comma else text


def _columns(header: list[str]) -> dict[str, int]:
    """Return the columns that are read, by what they are, and where they are."""
    found: dict[str, int] = {}
    for place, title in enumerate(header):
        word = _UNIT.sub("", title.strip().lower())
        key = next((key for key, words in _COLUMNS.items() if word in words), None)
        if key is not None:
            found.setdefault(key, place)
    return found


def _delimiter(header: str) -> str:
    return max(_DELIMITERS, key=header.count)


CSV: Final = Importer("CSV", (".csv", ".tsv"), is_table, _read)
