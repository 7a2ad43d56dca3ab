"""GPX (https://www.topografix.com/GPX/1/1/): its one route or track is the path; without one its waypoints are."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain
from typing import Final

from waypointctl.importers.importer import ImportedMission, Importer, ImportOptions, of_kind
from waypointctl.importers.report import Report
from waypointctl.importers.shapes import Line, Shapes, Spot, note_gaps
from waypointctl.importers.xml_source import Element, read_xml
from waypointctl.mission.file_kind import FileKind


def _read(source: bytes, options: ImportOptions) -> ImportedMission:
    report = Report(options.where)
    root = read_xml(source, report)
    shapes = Shapes(report, "route or track", "waypoint")
    for route in root.each("rte"):
        points = list(route.each("rtept"))
        if shaping := sum(map(_shaping_count, points)):
            report.left_out["shaping point (rpt) of a route: the robot goes straight between route points"] += shaping
        _add(shapes, route, points)
    for track in root.each("trk"):
        segments = [list(segment.each("trkpt")) for segment in track.each("trkseg")]
        note_gaps(report, segments)
        _add(shapes, track, list(chain.from_iterable(segments)))
    shapes.points += _spots(report, list(root.each("wpt")))
    return shapes.imported(options.name)


def _add(shapes: Shapes, element: Element, points: list[Element]) -> None:
    line = Line(element.name, element.text_of("name"), element.at)
    shapes.add_line(line, len(points), "points", lambda: _spots(shapes.report, points))


def _shaping_count(point: Element) -> int:
    """Return how many points Garmin's extension puts between a route point and the next."""
    extensions = chain.from_iterable(part.children for part in point.each("extensions"))
    return sum(len(list(extension.each("rpt"))) for extension in extensions)


def _spots(report: Report, points: Iterable[Element]) -> Iterable[Spot]:
    for point in points:
        latitude, longitude = (point.attributes.get(key, "") for key in ("lat", "lon"))
        if (place := report.place(point.at, latitude, longitude)) is not None:
            yield Spot(place, point.text_of("name"), point.at)


GPX: Final = Importer("GPX", (".gpx",), of_kind(FileKind.GPX), _read)
