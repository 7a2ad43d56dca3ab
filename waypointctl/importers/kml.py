"""KML: its one line is the path; without one its points are, in their order.

The format: https://developers.google.com/kml/documentation/kmlreference.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from typing import Final

from waypointctl.display_text import shown
from waypointctl.importers.importer import ImportedMission, Importer, ImportOptions, of_kind
from waypointctl.importers.local_frame import BODIES
from waypointctl.importers.report import Report
from waypointctl.importers.shapes import Line, Shapes, Spot, note_gaps
from waypointctl.importers.xml_source import Element, read_xml
from waypointctl.mission.file_kind import FileKind

_ORDER: Final = "KML is longitude,latitude"
_TARGET: Final = re.compile(r"\btarget=(\w+)")  # of the hint that names the body
_COMMA: Final = re.compile(r"\s{0,9},\s*")  # bounded: long runs of white space stay linear


def _read(source: bytes, options: ImportOptions) -> ImportedMission:
    report = Report(options.where)
    root = read_xml(source, report)
    shapes = Shapes(report, "LineString", "Point", _ORDER, _body(root, report))
    for placemark in _placemarks(root, report):
        geometries = list(_geometries(placemark))
        for geometry in geometries:
            _take(shapes, geometry, placemark.text_of("name"))
        if not geometries:
            report.left_out["Placemark without a geometry"] += 1
    return shapes.imported(options.name)


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


KML: Final = Importer("KML", (".kml",), of_kind(FileKind.KML), _read)
