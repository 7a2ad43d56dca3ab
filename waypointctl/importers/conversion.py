"""Another tool's file as a mission: the importer that reads it, found by its content; the mission file made of it."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

from waypointctl.display_text import printable
from waypointctl.errors import MissionError
from waypointctl.importers.csv_table import CSV
from waypointctl.importers.geojson import GEOJSON
from waypointctl.importers.gpx_and_kml import GPX, KML
from waypointctl.importers.importer import ImportedMission, Importer, Report, Stop, Zone, text_of
from waypointctl.importers.local_frame import BODIES, EARTH, Body, Place, Point
from waypointctl.importers.placed import Placed, placed
from waypointctl.importers.qgroundcontrol import QGC_PLAN
from waypointctl.importers.wpl import WPL
from waypointctl.mission.fields import DAY_S
from waypointctl.mission.file_kind import FileKind, kind_of
from waypointctl.mission.files import parse_mission
from waypointctl.mission.format import quoted
from waypointctl.mission.yaml_source import read_source
from waypointctl.paths import command_for_mission

IMPORTERS: Final[tuple[Importer, ...]] = (QGC_PLAN, WPL, GEOJSON, GPX, KML, CSV)

MAX_BYTES: Final = 10 << 20
_OF_MANY: Final = (".json", ".txt")  # suffixes of several formats
_READ: Final = (
    "QGroundControl plans, waypoint files (QGC WPL 110), GeoJSON, GPX, KML, and CSV with named columns are read"
)

_TIMEOUT_S: Final = 30.0
_HOME_TIMEOUT_S: Final = 300.0
_SLOWEST_MPS: Final = 1.0
_WIDTH: Final = 120
_MOST_NAME: Final = 60  # characters of a waypoint's name


def read_imported(path: Path) -> ImportedMission:
    """Return the mission in another tool's file.

    Raises:
        MissionError: the file does not exist, is in no format that is read, or has an error.
    """
    source = read_source(path, MissionError, MAX_BYTES)
    suffix = path.suffix.lower()
    importer = next((each for each in IMPORTERS if each.recognises(source)), None)
    importer = importer or _by_suffix(source, suffix)
    if importer is None:
        raise _unknown(source, path)
    report = Report(str(path))
    imported = importer.read(source, report)
    report.refuse()
    is_misnamed = suffix not in importer.suffixes and any(suffix in each.suffixes for each in IMPORTERS)
    remark = [f"is {importer.name} by its content, and read as that"] if is_misnamed else []
    left_out = (f"{count} x {what}" for what, count in report.left_out.items())
    return replace(
        imported,
        name=mission_name(imported.name or path.stem),
        left_out=(*imported.left_out, *left_out),
        remarks=(*imported.remarks, *remark),
    )


def mission_name(text: str) -> str:
    """Return a text as a mission's name, which names files."""
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", text)[:80].strip("-._")
    return name or "imported"


def _by_suffix(source: bytes, suffix: str) -> Importer | None:
    """Return the importer of a suffix for a file whose content does not show its format."""
    if kind_of(source) not in (None, FileKind.JSON) or suffix in _OF_MANY:
        return None
    return next((each for each in IMPORTERS if suffix in each.suffixes), None)


def _unknown(source: bytes, path: Path) -> MissionError:
    kind = kind_of(source)
    if kind is not None:
        has_hint = kind not in (FileKind.JSON, FileKind.HDTN_PLAN, FileKind.XML, FileKind.BINARY)
        return MissionError(kind.value, where=str(path), hint=None if has_hint else f"{_READ}.")
    text_of(source, Report(str(path)))
    hint = command_for_mission(str(path)) or "See docs/import.md for what each looks like."
    return MissionError(f"is not a file that can be imported: {_READ}", where=str(path), hint=hint)


def mission_text(
    imported: ImportedMission, where: str, policy: str, origin: Place | None = None, body: Body | None = None
) -> tuple[str, Placed]:
    """Return the mission file made from another tool's file, and its places in metres.

    Args:
        imported: its content.
        where: the file, for messages and for the comment at the top.
        policy: the policy's folder, relative to the mission file.
        origin: where x and y are 0; where the robot starts if it is left out.
        body: that the places are on; the file's body if it is left out.

    Raises:
        MissionError: it does not fit in a mission: too wide, or beyond a limit.
    """
    ground = placed(imported, where, origin, body or BODIES[imported.body])
    if not ground.stops:
        raise MissionError("has no waypoint besides the start", where=where)
    text = "".join(f"{line}\n" for line in _lines(imported.name, ground, where, policy))
    parse_mission(text.encode(), f"{where} as a mission")
    return text, ground


def _lines(name: str, ground: Placed, where: str, policy: str) -> Iterator[str]:
    yield from (f"# {printable(line)}" for line in _head(ground, where))
    yield f"name: {quoted(name)}"
    yield f"policy: {quoted(policy)}"
    if any(ground.start):
        yield from ("", "start:", f"  position: {_pair(ground.start)}")
    if (timeout_s := _timeout_s(ground)) > _TIMEOUT_S:
        yield from ("", "defaults:", f"  timeout: {timeout_s:g} s")
    yield from ("", "waypoints:")
    for (stop, point), label in zip(ground.stops, _names(ground), strict=True):
        yield f"  - {_stop(stop, point, label)}"
    if ground.zones:
        yield from ("", "onboard:")
        yield from _fence(ground)


def _head(ground: Placed, where: str) -> Iterator[str]:
    if ground.frame is None:
        yield f"From {where!r}. x and y are those of the file, in metres."
    else:
        (latitude, longitude), body = ground.frame.origin, ground.frame.body
        on = "" if body == EARTH else f" on {body.name}"
        yield f"From {where!r}. x is east and y is north of {latitude:.7f}, {longitude:.7f}{on}."
    for note in ground.left_out:
        yield f"Left out: {note}"


def _fence(ground: Placed) -> Iterator[str]:
    yield "  geofence:"
    for keep_in in (True, False):
        wanted = [(zone, points) for zone, points in ground.zones if zone.keep_in == keep_in]
        if wanted:
            yield f"    {'keep_in' if keep_in else 'keep_out'}:"
            for zone, points in wanted:
                yield from _area(zone, points)
        if keep_in and len(wanted) > 1:
            yield "    keep_in_match: all"
    if ground.return_to is not None:
        yield "    do: return_home"
        reached = [ground.start, *(point for _, point in ground.stops)]
        timeout_s = _leg_timeout_s(max(math.dist(ground.return_to, point) for point in reached))
        timeout = f", timeout: {timeout_s:g} s" if timeout_s > _HOME_TIMEOUT_S else ""
        yield f"  home: {{position: {_pair(ground.return_to)}{timeout}}}"


def _area(zone: Zone, points: tuple[Point, ...]) -> Iterator[str]:
    if zone.radius_m is not None:
        yield f"      - {{center: {_pair(points[0])}, radius: {zone.radius_m:.10g} m}}"
        return
    corners = [f"[{x_m:.10g}, {y_m:.10g}]" for x_m, y_m in points]
    if len(in_one_line := f"      - {{corners: [{', '.join(corners)}]}}") <= _WIDTH:
        yield in_one_line
    else:
        yield "      - corners:"
        yield from (f"          - {corner}" for corner in corners)


def _stop(stop: Stop, point: Point, name: str) -> str:
    parts = [f"name: {quoted(name)}"] if name else []
    parts.append(f"position: {_pair(point)}")
    if stop.radius_m is not None:
        parts += ["acceptance: radius", f"tolerance: {stop.radius_m:.10g} m"]
    if stop.hold_s:
        parts.append(f"hold: {stop.hold_s:.10g} s")
    if stop.observe:
        parts.append("observe: true")
    return f"{{{', '.join(parts)}}}"


def _names(ground: Placed) -> Iterator[str]:
    """Yield the waypoints' names, no two alike; a waypoint without one is called WP1, WP2, ... by its place."""
    used = {f"WP{place}" for place, (stop, _) in enumerate(ground.stops, 1) if not stop.name}
    for stop, _ in ground.stops:
        base = printable(re.sub(r"\s+", " ", stop.name).strip(), _MOST_NAME)[:_MOST_NAME] if stop.name else ""
        name, count = base, 1
        while base and name in used:
            count += 1
            name = f"{base[: _MOST_NAME - 6]} {count}"
        used.add(name)
        yield name


def _timeout_s(ground: Placed) -> float:
    """Return the time that the longest leg gets."""
    points = [ground.start, *(point for _, point in ground.stops)]
    return _leg_timeout_s(max(math.dist(a, b) for a, b in itertools.pairwise(points)))


def _leg_timeout_s(way_m: float) -> float:
    """Return one and a half times what a way takes at 1 m/s, in whole tens of seconds."""
    return min(math.ceil(1.5 * way_m / _SLOWEST_MPS / 10) * 10.0, DAY_S)


def _pair(point: Point) -> str:
    return f"[{point[0]:.10g} m, {point[1]:.10g} m]"
