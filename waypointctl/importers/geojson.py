"""GeoJSON (RFC 7946): its one line is the path; without a line its points are, in their order."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Any, Final

from waypointctl.display_text import counted, shown
from waypointctl.importers.importer import MOST_POSITIONS, ImportedMission, Importer, Report, number_of, of_kind
from waypointctl.importers.json_source import Part, read_json
from waypointctl.importers.shapes import Line, Shapes, Spot
from waypointctl.mission.file_kind import FileKind

# Latitude and longitude by the names that GeoServer, GDAL and others give them; of other bodies those of
# the IAU (00 and 02: planetocentric, east positive; 01 may count longitudes to the west, from 10 on they are metres).
_DEGREES: Final = re.compile(
    r"(?:urn:(?:x-)?ogc:def:crs:|https?://(?:www\.)?opengis\.net/def/crs/)?"
    r"(?:https?://(?:www\.)?opengis\.net/gml/srs/epsg\.xml#(?:4326|4979)"
    r"|OGC[:/][\d.]*[:/]?CRS84h?|EPSG[:/][\d.]*[:/]?(?:4326|4979)|CRS84|WGS ?84"
    r"|IAU(?:_?\d{4})?[:/]+(?:\d{4}[:/]+)?(?P<naif>301|499)0[02])",
    re.IGNORECASE,
)
_BODIES: Final = {"301": "moon", "499": "mars"}
_ORDER: Final = "GeoJSON is [longitude, latitude]"
_WANTED: Final = "[longitude, latitude] are needed, an altitude is left out"
_MOST_DEPTH: Final = 20  # of collections in collections
_GEOMETRIES: Final = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon")
_COLLECTION: Final = "GeometryCollection"


def _read(source: bytes, report: Report) -> ImportedMission:
    root = read_json(source, report)
    reader = _Reader(Shapes(report, "LineString", "Point", _ORDER))
    reader.take_frame(root)
    reader.take_root(root)
    own = root.value.get("name") if isinstance(root.value, dict) else None
    return reader.shapes.imported(own if isinstance(own, str) else "")


class _Reader:
    """Takes geometries out of a file."""

    def __init__(self, shapes: Shapes) -> None:
        self.shapes = shapes

    def take_frame(self, root: Part) -> None:
        """Take the body of a coordinate reference system; one that is not latitude and longitude is reported."""
        crs = root.get("crs")
        properties = None if crs is None else crs.at("properties")
        if properties is None:
            return
        name = properties.get("name") or properties.get("code") or properties.get("href") or properties
        text = f"EPSG:{name.value}" if name.path[-1] == "code" else name.value
        found = _DEGREES.fullmatch(text.strip()) if isinstance(text, str) else None
        if found is None:
            known = "WGS 84 (CRS84, EPSG:4326), the Moon (IAU_2015:30100) or Mars (IAU_2015:49900)"
            hint = "GeoJSON is in degrees (RFC 7946): write it with 'ogr2ogr -t_srs EPSG:4326'"
            name.add_problem(f"{shown(name.value)} is not latitude and longitude of {known}; {hint}")
        elif found["naif"]:
            self.shapes.body = _BODIES[found["naif"]]

    def take_root(self, root: Part) -> None:
        """Take a whole file."""
        kind = root.at("type")
        if kind is None:
            return
        if kind.value == "FeatureCollection":
            features = root.at("features")
            for feature in () if features is None else features.elements():
                if feature.value is None:
                    self.shapes.report.left_out["null in place of a Feature"] += 1
                elif (type_of := feature.at("type")) is not None and type_of.one_of("Feature"):
                    self._feature(feature)
        elif kind.value == "Feature":
            self._feature(root)
        else:
            self._geometry(root, "", ("Feature", "FeatureCollection"))

    def _feature(self, feature: Part) -> None:
        geometry = feature.get("geometry")
        if geometry is None:  # RFC 7946, 3.2: it has no place
            self.shapes.report.left_out["Feature without a geometry"] += 1
            return
        properties = feature.value.get("properties")
        names = (
            [value for key, value in properties.items() if key.lower() == "name"]
            if isinstance(properties, dict)
            else []
        )
        name = names[0] if names else ""
        self._geometry(geometry, str(name) if isinstance(name, str) or type(name) is int else "")

    def _geometry(self, part: Part, name: str, also: tuple[str, ...] = (), depth: int = 0) -> None:
        kind = part.at("type")
        if kind is None or not kind.one_of(*_GEOMETRIES, _COLLECTION, *also):
            return
        if kind.value == _COLLECTION:
            if depth == _MOST_DEPTH:
                part.add_problem(f"is a {_COLLECTION} more than {_MOST_DEPTH} deep in others")
                return
            for inner in part.each("geometries"):
                self._geometry(inner, name, depth=depth + 1)
            return
        coordinates = part.at("coordinates")
        if coordinates is not None:
            self._coordinates(kind.value, coordinates, name)

    def _coordinates(self, kind: str, coordinates: Part, name: str) -> None:
        parts = coordinates.elements() if kind.startswith("Multi") else iter((coordinates,))
        if coordinates.value == []:  # RFC 7946, 3.1: an empty list is no position
            self.shapes.report.left_out[f"{kind} without coordinates"] += 1
        elif kind.endswith("LineString"):
            for line in _joined(parts):
                self._line(line, name)
        elif kind.endswith("Point"):
            for position in parts:
                self._point(position, name)
        else:
            self.shapes.others[kind] += 1

    def _line(self, parts: Sequence[Part], name: str) -> None:
        counts = [len(part.value) if isinstance(part.value, list) else MOST_POSITIONS for part in parts]
        if (least := min(counts)) < 2:
            parts[counts.index(least)].add_problem(f"has {counted(least, 'positions')}; a line has 2 and more")
        else:
            line = Line("LineString", name, parts[0].at_text)
            self.shapes.add_line(line, sum(counts), "positions", lambda: self._spots(parts))

    def _spots(self, parts: Sequence[Part]) -> Iterator[Spot]:
        for part in parts:
            for position in islice(part.elements(), 0 if part is parts[0] else 1, None):
                if (spot := self._spot(position, "")) is not None:
                    yield spot

    def _point(self, position: Part, name: str) -> None:
        if (spot := self._spot(position, name)) is not None:
            self.shapes.points.append(spot)

    def _spot(self, position: Part, name: str) -> Spot | None:
        value = position.value
        if not isinstance(value, list):
            position.add_problem(f"{shown(value)} is not a list", "not a list")
        elif len(value) < 2:
            position.add_problem(f"has {counted(len(value), 'numbers')}; {_WANTED}", "too few numbers")
        elif isinstance(value[0], str) or isinstance(value[1], str):
            position.add_problem(f"{shown(value[0])}, {shown(value[1])} are not numbers", "not numbers")
        elif (place := position.report.place(position.at_text, value[1], value[0], _ORDER)) is not None:
            return Spot(place, name, position.at_text)
        return None


def _joined(parts: Iterable[Part]) -> Iterator[list[Part]]:
    """Yield lines: parts of which each begins where the one before ends are one line.

    RFC 7946 (3.1.9) cuts a line at the antimeridian into such parts.
    """
    line: list[Part] = []
    for part in parts:
        if line and not _goes_on(line[-1].value, part.value):
            yield line
            line = []
        line.append(part)
    if line:
        yield line


def _goes_on(before: Any, after: Any) -> bool:
    """Tell whether a line begins where another ends."""
    if not (before and after and isinstance(before, list) and isinstance(after, list)):
        return False
    end, begin = before[-1], after[0]
    if not (isinstance(end, list) and isinstance(begin, list) and min(len(end), len(begin)) >= 2):
        return False
    numbers = [number_of(value) for value in (*end[:2], *begin[:2])]
    if None in numbers:
        return False
    longitude, latitude, other_longitude, other_latitude = (number or 0.0 for number in numbers)
    return latitude == other_latitude and (longitude - other_longitude) % 360 == 0


GEOJSON: Final = Importer("GeoJSON", (".geojson", ".json"), of_kind(FileKind.GEOJSON), _read)
