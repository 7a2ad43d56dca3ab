"""GPX (https://www.topografix.com/GPX/1/1/): its one route or track is the path; without one its waypoints are."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

from waypointctl.importers.report import Report
from waypointctl.importers.shapes import Shapes, Spot, note_gaps, too_many
from waypointctl.importers.survey import MOST_POSITIONS, Survey
from waypointctl.importers.xml_source import Element, read_xml


def read_gpx(source: bytes, report: Report, name: str) -> Survey:
    """Read a route or a track, or the waypoints of a file without one.

    Args:
        source: the file's bytes.
        report: what is wrong with it goes there.
        name: of the mission, where the file gives none.

    Raises:
        MissionError: it has not one route or track, and no waypoints instead, with all that is wrong.
    """
    root = read_xml(source, report)
    shapes = Shapes(report, "route or track", "waypoint")
    for route in root.each("rte"):
        points = list(route.each("rtept"))
        if shaping := sum(map(_shaping_count, points)):
            report.left_out["shaping point (rpt) of a route: the robot walks straight between route points"] += shaping
        _add(shapes, route, points)
    for track in root.each("trk"):
        segments = [list(segment.each("trkpt")) for segment in track.each("trkseg")]
        note_gaps(report, segments)
        _add(shapes, track, list(chain.from_iterable(segments)))
    shapes.points += _spots(report, list(root.each("wpt")))
    return shapes.survey(name)


def _add(shapes: Shapes, line: Element, points: list[Element]) -> None:
    if not points:
        shapes.report.left_out[f"{line.name} without points"] += 1
    elif len(points) > MOST_POSITIONS:
        shapes.report.add_problem(line.at, too_many(len(points), "points"))
    else:
        shapes.add_line(line.text_of("name"), line.at, lambda: _spots(shapes.report, points))


def _shaping_count(point: Element) -> int:
    """Return how many points Garmin's extension puts between a route point and the next."""
    extensions = chain.from_iterable(part.children for part in point.each("extensions"))
    return sum(len(list(extension.each("rpt"))) for extension in extensions)


def _spots(report: Report, points: Iterable[Element]) -> Iterable[Spot]:
    for point in points:
        latitude, longitude = (point.attributes.get(key, "") for key in ("lat", "lon"))
        if (place := report.place(point.at, latitude, longitude)) is not None:
            yield Spot(place, point.text_of("name"), point.at)
