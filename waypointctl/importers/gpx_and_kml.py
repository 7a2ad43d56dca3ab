"""GPX and KML: the one route, track or line is the path; without one the waypoints or points are, in their order.

GPX: https://www.topografix.com/GPX/1/1/. KML: https://developers.google.com/kml/documentation/kmlreference.

The XML is read with nothing that can execute, grow or fetch. A document type declaration is refused: it declares
entities, which can grow without bound ("billion laughs") or name other files and hosts, and neither format has one. The
parser is Python's own expat, whose handlers refuse it before any entity is declared.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from typing import Final
from xml.parsers import expat

from waypointctl.display_text import shown
from waypointctl.errors import MissionError
from waypointctl.importers.importer import ImportedMission, Importer, Report, of_kind
from waypointctl.importers.local_frame import BODIES
from waypointctl.importers.shapes import Line, Shapes, Spot, note_gaps
from waypointctl.mission.file_kind import FileKind

_MOST_ELEMENTS: Final = 300_000
_MOST_DEPTH: Final = 100

_ORDER: Final = "KML is longitude,latitude"
_TARGET: Final = re.compile(r"\btarget=(\w+)")  # of the hint that names the body
_COMMA: Final = re.compile(r"\s{0,9},\s*")  # bounded: long runs of white space stay linear


@dataclass(slots=True)
class Element:
    """An element by its name without a namespace, with its place in the file."""

    name: str
    line: int
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)

    @property
    def at(self) -> str:
        """Where it is, for messages."""
        return f"line {self.line} ({self.name})"

    @property
    def text(self) -> str:
        """Its own text, without the space around it."""
        return "".join(self.parts).strip()

    def each(self, *names: str) -> Iterator[Element]:
        """Yield the children of these names."""
        return (child for child in self.children if child.name in names)

    def text_of(self, name: str) -> str:
        """Return the text of the first child of a name, empty where there is none."""
        return next((child.text for child in self.each(name)), "")


def read_xml(source: bytes, report: Report) -> Element:
    """Return the root of an XML text.

    Raises:
        MissionError: it is not XML, or has a document type declaration, or is larger or deeper than is read.
    """
    builder = _Builder(report.where)
    try:
        builder.parser.Parse(source, True)
    except expat.ExpatError as error:
        problem = f"is not XML: {expat.errors.messages[error.code]}"
        raise MissionError(problem, where=f"{report.where}:{error.lineno}:{error.offset + 1}") from error
    except (LookupError, ValueError) as error:
        raise MissionError(f"is not XML that can be read: {error}", where=report.where) from error
    return builder.root


class _Builder:
    """Builds elements from what the parser finds."""

    def __init__(self, where: str) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._doctype
        self._where = where
        self._count = 0
        self._open: list[Element] = [Element("", 0, {})]

    @property
    def root(self) -> Element:
        return self._open[0].children[0]

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > _MOST_ELEMENTS:
            raise MissionError(f"has more than {_MOST_ELEMENTS:,} elements", where=self._where)
        if len(self._open) > _MOST_DEPTH:
            raise MissionError(f"has elements more than {_MOST_DEPTH} deep", where=self._where)
        element = Element(name.rpartition(":")[2], self.parser.CurrentLineNumber, attributes)
        self._open[-1].children.append(element)
        self._open.append(element)

    def _end(self, name: str) -> None:
        self._open.pop()

    def _text(self, data: str) -> None:
        self._open[-1].parts.append(data)

    def _doctype(self, *_: object) -> None:
        problem = "has a document type declaration (<!DOCTYPE ...>), which is not read: it can name other files"
        raise MissionError(problem, where=f"{self._where}:{self.parser.CurrentLineNumber}")


def _read_gpx(source: bytes, report: Report) -> ImportedMission:
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
    shapes.points += _track_points(report, list(root.each("wpt")))
    return shapes.imported()


def _add(shapes: Shapes, element: Element, points: list[Element]) -> None:
    line = Line(element.name, element.text_of("name"), element.at)
    shapes.add_line(line, len(points), "points", lambda: _track_points(shapes.report, points))


def _shaping_count(point: Element) -> int:
    """Return how many points Garmin's extension puts between a route point and the next."""
    extensions = chain.from_iterable(part.children for part in point.each("extensions"))
    return sum(len(list(extension.each("rpt"))) for extension in extensions)


def _track_points(report: Report, points: Iterable[Element]) -> Iterable[Spot]:
    for point in points:
        latitude, longitude = (point.attributes.get(key, "") for key in ("lat", "lon"))
        if (place := report.place(point.at, latitude, longitude)) is not None:
            yield Spot(place, point.text_of("name"), point.at)


GPX: Final = Importer("GPX", (".gpx",), of_kind(FileKind.GPX), _read_gpx)


def _read_kml(source: bytes, report: Report) -> ImportedMission:
    root = read_xml(source, report)
    shapes = Shapes(report, "LineString", "Point", _ORDER, _body(root, report))
    for placemark in _placemarks(root, report):
        geometries = list(_geometries(placemark))
        for geometry in geometries:
            _take(shapes, geometry, placemark.text_of("name"))
        if not geometries:
            report.left_out["Placemark without a geometry"] += 1
    return shapes.imported()


def _body(root: Element, report: Report) -> str:
    """Return the body that a file is about, of those that there are; any other is reported."""
    target = _TARGET.search(root.attributes.get("hint", ""))
    body = "earth" if target is None else target[1].lower()
    if body in BODIES:
        return body
    report.add_problem(root.at, f"its hint names {shown(body)}, which is not one of {', '.join(BODIES)}")
    return "earth"


def _placemarks(element: Element, report: Report) -> Iterator[Element]:
    for child in element.children:
        if child.name == "Placemark":
            yield child
        elif child.name in ("NetworkLink", "GroundOverlay", "PhotoOverlay", "ScreenOverlay"):
            report.left_out[child.name] += 1
        else:
            yield from _placemarks(child, report)


def _geometries(element: Element) -> Iterator[Element]:
    for child in element.children:
        if child.name in ("LineString", "Point", "Polygon", "LinearRing", "Track", "MultiTrack", "Model"):
            yield child
        elif child.name == "MultiGeometry":
            yield from _geometries(child)


def _take(shapes: Shapes, geometry: Element, name: str) -> None:
    report = shapes.report
    if geometry.name not in ("LineString", "Track", "MultiTrack", "Point"):
        shapes.others[geometry.name] += 1
        return
    separator = None if geometry.name.endswith("Track") else ","
    if separator is None:
        tracks = list(geometry.each("Track")) if geometry.name == "MultiTrack" else [geometry]
        parts = [[coord.text for coord in track.each("coord")] for track in tracks]
        note_gaps(report, parts)
        texts = list(chain.from_iterable(parts))
    else:
        texts = _COMMA.sub(",", geometry.text_of("coordinates")).split()
    if geometry.name == "Point" and texts:
        shapes.points += _spots(report, texts[:1], separator, geometry, name)
    else:
        line = Line(geometry.name, name, geometry.at)
        things = "positions" if texts else "coordinates"
        shapes.add_line(line, len(texts), things, lambda: _spots(report, texts, separator, geometry, ""))


def _spots(report: Report, texts: list[str], separator: str | None, geometry: Element, name: str) -> Iterator[Spot]:
    for number, text in enumerate(texts, 1):
        at = geometry.at if len(texts) == 1 else f"{geometry.at}, position {number}"
        longitude, *others = text.split(separator, 2)
        if not others:
            report.add_problem(at, f"{shown(text)} is not longitude,latitude", "not longitude,latitude")
        elif (place := report.place(at, others[0], longitude, _ORDER)) is not None:
            yield Spot(place, name, at)


KML: Final = Importer("KML", (".kml",), of_kind(FileKind.KML), _read_kml)
