"""GPX (https://www.topografix.com/GPX/1/1/): its one route or track is the path; without one its waypoints are."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

from waypointctl.importers.report import Report
from waypointctl.importers.shapes import Shapes, Spot, too_many
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
        _add(shapes, route, list(route.each("rtept")))
    for track in root.each("trk"):
        segments = [list(segment.each("trkpt")) for segment in track.each("trkseg")]
        gaps = sum(bool(segment) for segment in segments) - 1
        if gaps > 0:
            report.left_out["gap between segments of a track: the robot walks straight across"] += gaps
        _add(shapes, track, list(chain.from_iterable(segments)))
    shapes.points += _spots(report, list(root.each("wpt")))
    return shapes.survey(name)


def _add(shapes: Shapes, line: Element, points: list[Element]) -> None:
    if not points:
        shapes.report.left_out[f"{line.name} without points"] += 1
    elif len(points) > MOST_POSITIONS:
        shapes.report.complain(line.at, too_many(len(points), "points"))
    else:
        shapes.add_line(line.text_of("name"), line.at, lambda: _spots(shapes.report, points))


def _spots(report: Report, points: Iterable[Element]) -> Iterable[Spot]:
    for point in points:
        latitude, longitude = (point.attributes.get(key, "") for key in ("lat", "lon"))
        if (place := report.place(point.at, latitude, longitude)) is not None:
            yield Spot(place, point.text_of("name"), point.at)
