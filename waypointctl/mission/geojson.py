"""A line of GeoJSON (RFC 7946): the robot starts at its first position and walks to the others."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from waypointctl.mission.json_source import Part, read_json
from waypointctl.mission.local_frame import Place
from waypointctl.mission.survey import Stop, Survey, mission_name, place_of
from waypointctl.mission.wording import counted

_WGS_84: Final = ("urn:ogc:def:crs:OGC:1.3:CRS84", "urn:ogc:def:crs:OGC::CRS84", "EPSG:4326")
_ORDER: Final = "GeoJSON is [longitude, latitude]"
_WANTED: Final = "[longitude, latitude] are needed, an altitude is left out"
_MOST: Final = 1000  # waypoints of a mission


def read_geojson(path: Path, origin: Place | None = None) -> Survey:
    """Read a LineString, or a Feature or FeatureCollection with one.

    Args:
        path: of the file.
        origin: of the local frame; the line's first position where it is left out.

    Raises:
        MissionError: there is no such file, or it is no line, with all that is wrong.
    """
    root = read_json(path)
    _refuse_other_frames(root)
    lines = list(_lines(root))
    root.report.refuse()
    if len(lines) != 1:
        root.complain(f"has {counted(len(lines), 'lines')}; a mission is one LineString")
        root.report.refuse()
    line, name = lines[0]
    places = tuple(_places(line))
    root.report.refuse()
    stops = tuple(Stop(place) for place in places[1:])
    notes = tuple(root.report.notes)
    name = mission_name(name or path.stem)
    return Survey(name, origin or places[0], places[0], stops, notes=notes, order=_ORDER)


def _refuse_other_frames(root: Part) -> None:
    """Report a coordinate reference system of GeoJSON's first version, where it is not what the RFC wants."""
    if not root.has("crs"):
        return
    crs = root.at("crs")
    properties = None if crs is None else crs.at("properties")
    name = None if properties is None else properties.at("name")
    if name is not None:
        name.one_of(*_WGS_84)


def _lines(part: Part) -> Iterator[tuple[Part, str]]:
    """Yield each LineString's positions, and the name that its feature gives it."""
    kind = part.at("type")
    if kind is None or not kind.one_of("LineString", "Feature", "FeatureCollection"):
        return
    if kind.value == "LineString":
        yield from _line(part, "")
    elif kind.value == "Feature":
        yield from _line_of(part)
    else:
        features = part.at("features")
        for feature in () if features is None else features.elements():
            if (type_of := feature.at("type")) is not None and type_of.one_of("Feature"):
                yield from _line_of(feature)


def _line_of(feature: Part) -> Iterator[tuple[Part, str]]:
    geometry = feature.at("geometry")
    kind = None if geometry is None else geometry.at("type")
    if geometry is None or kind is None:
        return
    properties = feature.value.get("properties")
    name = properties.get("name") if isinstance(properties, dict) else None
    if kind.one_of("LineString"):
        yield from _line(geometry, name if isinstance(name, str) else "")


def _line(geometry: Part, name: str) -> Iterator[tuple[Part, str]]:
    coordinates = geometry.at("coordinates")
    if coordinates is not None:
        yield coordinates, name


def _places(line: Part) -> Iterator[Place]:
    positions = list(line.elements())
    if isinstance(line.value, list) and not 2 <= len(positions) <= _MOST + 1:
        line.complain(
            f"has {counted(len(positions), 'positions')}; 2 to {_MOST + 1} are allowed: the start and the waypoints"
        )
        return
    for position in positions:
        numbers = list(position.elements())
        if not isinstance(position.value, list):
            continue
        if not 2 <= len(numbers) <= 3:
            position.complain(f"has {counted(len(numbers), 'numbers')}; {_WANTED}")
            continue
        if _is_swapped(position.value):
            position.complain(f"{position.value[1]:g} is no latitude: {_ORDER}, and these look swapped")
            continue
        place = place_of(numbers[1], numbers[0])
        if place is not None:
            yield place


def _is_swapped(position: list[object]) -> bool:
    """Tell whether a position's numbers would be a place the other way round alone."""
    longitude, latitude = position[:2]
    if not (isinstance(longitude, int | float) and isinstance(latitude, int | float)):
        return False
    return abs(longitude) <= 90 < abs(latitude) <= 180
