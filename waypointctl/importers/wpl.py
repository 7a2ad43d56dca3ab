"""Waypoint files, "QGC WPL 110": a line an item, its twelve values apart by tabs or spaces (.waypoints, .txt).

    QGC WPL 110
    0  1  0  16  0  0  0  0  60.0    25.0  10  1     number, current, frame, command, seven parameters, autocontinue
    1  0  3  16  5  0  0  0  60.0002 25.0  10  1

The format: https://mavlink.io/en/file_formats/. Item 0 is the home. Lines that begin with '#' are
comments, which MAVProxy writes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from waypointctl.display_text import counted, shown
from waypointctl.errors import MissionError
from waypointctl.importers.importer import ImportedMission, Importer, Report, number_of, of_kind, text_of
from waypointctl.importers.json_source import MOST_ENTRIES
from waypointctl.importers.local_frame import Place
from waypointctl.importers.mavlink import WAYPOINT
from waypointctl.importers.mavlink_way import LATITUDE, LONGITUDE, PARAMETERS, Item, follow
from waypointctl.mission.file_kind import FileKind

_HEADER: Final = ["QGC", "WPL", "110"]
_VALUES: Final = 12
_NUMBER, _CURRENT, _FRAME, _COMMAND, _PARAMS, _GOES_ON = 0, 1, 2, 3, 4, 11


def _read(source: bytes, report: Report) -> ImportedMission:
    lines = text_of(source, report).splitlines()
    begin, header = next((number, line) for number, line in enumerate(lines, 1) if line.strip())
    if header.split() != _HEADER:
        raise MissionError(f"begins with {shown(header)}; 'QGC WPL 110' is read", where=f"{report.where}:{begin}")
    if (count := len(lines) - begin) > MOST_ENTRIES:
        raise MissionError(f"has {count:,} lines; at most {MOST_ENTRIES:,} are read", where=report.where)
    items = list(_items(lines, begin, report))
    home: Place | None = None
    first = next(iter(items), None)
    start_at = "the home (item 0)"
    if first is not None and first.number == 0 and first.command == WAYPOINT:
        start_at = f"{first.at} (the home)"
        home = report.place(first.at, first.params[LATITUDE], first.params[LONGITUDE])
        items = items[1:]
    stops = follow(items, report)
    if not stops and report.is_clean:
        report.add_problem("", "has no waypoint to go to: at least one item of command 16 beside the home is needed")
    return ImportedMission(home, stops, start_at=start_at, is_home=True)


def _items(lines: list[str], begin: int, report: Report) -> Iterator[Item]:
    """Yield the items of the lines after the first `begin`."""
    for number, line in enumerate(lines[begin:], begin + 1):
        values = line.split()
        at = f"line {number}"
        if not values or line.startswith("#"):
            continue
        if len(values) != _VALUES:
            report.add_problem(at, f"has {counted(len(values), 'values')}; an item has {_VALUES}", "number of values")
            continue
        wrong = next((value for value in values if number_of(value) is None and not _is_nan(value)), None)
        whole = [_whole(values[place]) for place in (_NUMBER, _FRAME, _COMMAND)]
        if wrong is not None or None in whole:
            found = shown(wrong) if wrong is not None else "its number, frame or command"
            report.add_problem(
                at, f"{found} is not a {'number' if wrong is not None else 'whole number'}", "not a number"
            )
            continue
        index, frame, command = (each for each in whole if each is not None)
        if number_of(values[_CURRENT]) and index > 1:
            report.left_out[f"mark of {at} as the current item: the mission starts with its first"] += 1
        params = tuple(number_of(value) for value in values[_PARAMS : _PARAMS + PARAMETERS])
        yield Item(at, index, command, frame, params, goes_on=number_of(values[_GOES_ON]) != 0)


def _is_nan(value: str) -> bool:
    try:
        return math.isnan(float(value))
    except ValueError:
        return False


def _whole(value: str) -> int | None:
    number = number_of(value)
    return int(number) if number is not None and number.is_integer() else None


WPL: Final = Importer("a waypoint file (QGC WPL)", (".waypoints", ".txt"), of_kind(FileKind.WPL), _read)
