"""KML: its one line is the path; without one its points are, in their order.

The format: https://developers.google.com/kml/documentation/kmlreference.
"""

from __future__ import annotations

from collections.abc import Iterator

from waypointctl.importers.report import Report
from waypointctl.importers.shapes import Shapes, Spot, too_many
from waypointctl.importers.survey import MOST_POSITIONS, Survey
from waypointctl.importers.xml_source import Element, read_xml
from waypointctl.mission.wording import shown


def read_kml(source: bytes, report: Report, name: str) -> Survey:
    """Read a LineString or a gx:Track, or the Points of a file without one. Nothing that it links to is fetched.

    Args:
        source: the file's bytes.
        report: what is wrong with it goes there.
        name: of the mission, where the file gives none.

    Raises:
        MissionError: it has not one line, and no points instead, with all that is wrong.
    """
    shapes = Shapes(report, "LineString", "Point", "KML is longitude,latitude")
    for placemark in _placemarks(read_xml(source, report), report):
        geometries = list(_geometries(placemark))
        for geometry in geometries:
            _take(shapes, geometry, placemark.text_of("name"))
        if not geometries:
            report.left_out["Placemark without a geometry"] += 1
    return shapes.survey(name)


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
        if child.name in ("LineString", "Point", "Polygon", "LinearRing", "Track", "Model"):
            yield child
        elif child.name in ("MultiGeometry", "MultiTrack"):
            yield from _geometries(child)


def _take(shapes: Shapes, geometry: Element, name: str) -> None:
    report = shapes.report
    if geometry.name not in ("LineString", "Track", "Point"):
        shapes.others[geometry.name] += 1
        return
    separator = None if geometry.name == "Track" else ","
    if separator is None:
        texts = [coord.text for coord in geometry.each("coord")]
    else:
        texts = geometry.text_of("coordinates").split()
    if not texts:
        report.left_out[f"{geometry.name} without coordinates"] += 1
    elif len(texts) > MOST_POSITIONS:
        report.complain(geometry.at, too_many(len(texts), "positions"))
    elif geometry.name == "Point":
        shapes.points += _spots(report, texts[:1], separator, geometry, name)
    else:
        shapes.add_line(name, geometry.at, lambda: _spots(report, texts, separator, geometry, ""))


def _spots(report: Report, texts: list[str], separator: str | None, geometry: Element, name: str) -> Iterator[Spot]:
    for number, text in enumerate(texts, 1):
        at = geometry.at if len(texts) == 1 else f"{geometry.at}, position {number}"
        longitude, *others = text.split(separator, 2)
        if not others:
            report.complain(at, f"{shown(text)} is not longitude,latitude", "not longitude,latitude")
        elif (place := report.place(at, others[0], longitude)) is not None:
            yield Spot(place, name, at)
