from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.importers.reading import imported
from waypointctl.errors import MissionError

LINE: dict[str, Any] = {
    "type": "LineString",
    "coordinates": [[8.5456, 47.3977], [8.5457, 47.3977, 5], [8.5457, 47.3978]],
}
ON_THE_WAY = [(7.55, 0.0), (7.55, 11.12)]  # 75.5 km a degree of longitude at 47.4 degrees, 111.2 one of latitude
POINT: dict[str, Any] = {"type": "Point", "coordinates": [8.5456, 47.3977]}
POLYGON: dict[str, Any] = {"type": "Polygon", "coordinates": [[[8, 47], [9, 47], [9, 48], [8, 47]]]}


def feature(geometry: object, **properties: object) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties or None}


def collection(*features: object, **more: object) -> dict[str, Any]:
    return {"type": "FeatureCollection", "features": list(features), **more}


def with_crs(name: object) -> dict[str, Any]:
    return LINE | {"crs": {"type": "name", "properties": {"name": name}}}


@pytest.mark.parametrize(
    ("content", "name", "left_out"),
    [
        (LINE, "line", ()),
        (feature(LINE, name="the yard (2)"), "the-yard-2", ()),
        (collection(feature(LINE)), "line", ()),
        (collection(feature(LINE), name="route 7"), "route-7", ()),
        (collection(feature(LINE, Name="B"), name="route 7"), "B", ()),
        (feature(LINE, name=7), "7", ()),
        (feature({"type": "MultiLineString", "coordinates": [LINE["coordinates"]]}), "line", ()),
        (
            {"type": "MultiLineString", "coordinates": [LINE["coordinates"][:2], LINE["coordinates"][1:]]},
            "line",
            (),
        ),
        ({"type": "GeometryCollection", "geometries": [LINE, POINT]}, "line", ("1 Point",)),
        (collection(None, feature(LINE), None), "line", ("2 x null in place of a Feature",)),
        (collection(feature(POINT), feature(LINE), feature(POINT)), "line", ("2 Points",)),
        (collection(feature(POLYGON), feature(LINE)), "line", ("1 Polygon",)),
        (
            collection(feature(LINE), feature({"type": "MultiPolygon", "coordinates": [POLYGON["coordinates"]]})),
            "line",
            ("1 MultiPolygon",),
        ),
        (collection(feature(None), feature(LINE)), "line", ("1 x Feature without a geometry",)),
        (collection({"type": "Feature", "properties": {}}, feature(LINE)), "line", ("1 x Feature without a geometry",)),
        (
            collection(feature({"type": "LineString", "coordinates": []}), feature(LINE)),
            "line",
            ("1 x LineString without coordinates",),
        ),
    ],
)
def test_the_one_line_is_the_path_and_all_else_is_counted(
    tmp_path: Path, content: object, name: str, left_out: tuple[str, ...]
) -> None:
    found = imported(tmp_path, content, "line.geojson")
    assert (found.mission.name, found.mission.start.position_m) == (name, (0, 0))
    assert found.legs == ON_THE_WAY
    assert found.left_out == left_out


@pytest.mark.parametrize(
    "content",
    [
        collection(
            *(
                feature({"type": "Point", "coordinates": position}, name=f"stop {number}")
                for number, position in enumerate(LINE["coordinates"])
            ),
            feature(POLYGON),
        ),
        collection(
            feature({"type": "MultiPoint", "coordinates": LINE["coordinates"][:2]}, name="stop 1"),
            feature({"type": "Point", "coordinates": LINE["coordinates"][2]}, name="stop 2"),
            feature(POLYGON),
        ),
    ],
)
def test_without_a_line_the_points_are_the_path_in_their_order(tmp_path: Path, content: object) -> None:
    found = imported(tmp_path, content, "points.geojson")
    assert found.mission.start.position_m == (0, 0)
    assert found.legs == ON_THE_WAY
    assert [leg.name for leg in found.all_legs] == ["stop 1", "stop 2"]
    assert found.left_out == ("1 Polygon",)


def test_waypoints_are_called_as_the_points_are_and_no_two_alike(tmp_path: Path) -> None:
    names = ["start", "pit", "pit", "WP4", "", "a\nb\x1b[31m", "x" * 99]
    points = [
        feature({"type": "Point", "coordinates": [8.5456, 47.3977 + at * 1e-4]}, name=name)
        for at, name in enumerate(names)
    ]
    legs = imported(tmp_path, collection(*points), "points.geojson").all_legs
    assert [leg.name for leg in legs[:5]] == ["pit", "pit 2", "WP4 2", "WP4", r"a b\u001b[31m"]
    assert len(legs[5].name) == 60


@pytest.mark.parametrize(
    "name",
    [
        "urn:ogc:def:crs:OGC:1.3:CRS84",
        "urn:ogc:def:crs:OGC::CRS84",
        "urn:ogc:def:crs:OGC:1.3:CRS84h",
        "OGC:CRS84",
        "http://www.opengis.net/def/crs/OGC/1.3/CRS84",
        "urn:ogc:def:crs:EPSG::4326",
        "urn:ogc:def:crs:EPSG:6.9:4326",
        "urn:x-ogc:def:crs:EPSG:4326",
        "http://www.opengis.net/def/crs/EPSG/0/4326",
        "http://www.opengis.net/gml/srs/epsg.xml#4326",
        "EPSG:4326",
        "epsg:4979",
        "WGS84",
    ],
)
def test_latitude_and_longitude_have_many_names(tmp_path: Path, name: str) -> None:
    assert imported(tmp_path, with_crs(name), "line.geojson").legs == ON_THE_WAY


def test_an_old_code_is_a_name_too(tmp_path: Path) -> None:
    old = LINE | {"crs": {"type": "EPSG", "properties": {"code": 4326}}}
    assert imported(tmp_path, old, "line.geojson").legs == ON_THE_WAY
    assert imported(tmp_path, LINE | {"crs": None}, "line.geojson").legs == ON_THE_WAY


@pytest.mark.parametrize(
    ("name", "metres"),
    [("urn:ogc:def:crs:IAU_2015::30100", 3.03), ("IAU:30100", 3.03), ("IAU_2015:49900", 5.93), ("EPSG:4326", 11.12)],
)
def test_a_frame_of_another_body_is_that_bodys(tmp_path: Path, name: str, metres: float) -> None:
    found = imported(tmp_path, with_crs(name), "line.geojson")
    assert found.legs[1][1] == pytest.approx(metres, abs=0.01)


def test_an_origin_moves_the_frame_and_the_start(tmp_path: Path) -> None:
    found = imported(tmp_path, LINE, "line.json", origin=(47.3976, 8.5456))
    assert found.mission.start.position_m == pytest.approx((0, 11.12), abs=0.01)


def test_what_it_says_of_itself(tmp_path: Path) -> None:
    text = imported(tmp_path, LINE, "line.json").text
    assert text.startswith("# From 'line.json'. x is east and y is north of 47.3977000, 8.5456000.\n")
    assert 'policy: "p"' in text


def test_a_byte_order_mark_is_no_content(tmp_path: Path) -> None:
    assert imported(tmp_path, b"\xef\xbb\xbf" + json.dumps(LINE).encode(), "line.geojson").legs == ON_THE_WAY


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", r":1:2: is not JSON"),
        ('{"type": "Feature"} {"type": "Feature"}', "holds more than one JSON text"),
        ("[" * 100_000, "is nested too deep"),
        ('{"type": ' + "1" * 5000 + "}", "a number in it is too long"),
        ('{"type": NaN}', "type: nan is not 'Point' or"),
        ([], "a list of 0 is not a mapping"),
        ({"type": "Topology"}, r"type: 'Topology' is not 'Point' or .* or 'FeatureCollection'"),
        ({"type": "LineString"}, "'coordinates' is missing"),
        (collection(), "has no LineString; a mission is one LineString, or 2 Points and more$"),
        (collection(feature(POINT), feature(POLYGON)), "has no LineString and 1 Point, 1 Polygon; a mission is one"),
        (
            collection(feature(LINE, name="a"), feature(LINE)),
            r"has 2 lines \('a', features\[1\]\.geometry\.coordinates\); a mission is one LineString: keep one",
        ),
        ({"type": "LineString", "coordinates": [[1, 2]]}, r"coordinates: has 1 position; a line has 2 and more"),
        (
            {"type": "LineString", "coordinates": [[1, 2]] * 20_001},
            r"coordinates: has 20,001 positions; at most 20,000",
        ),
        (
            {"type": "LineString", "coordinates": [[25 + at * 1e-5, 60 + at % 2 * 1e-3] for at in range(3000)]},
            r"has 3,000 positions, and more than 1,000 even without those within 0\.5 m of the straight way",
        ),
        (
            collection(*[feature(POINT)] * 1002),
            r"has 1,002 Points; at most 1,001 are allowed, the start and 1,000 waypoints: cut it",
        ),
        (collection(*[feature(POINT)] * 20_001), r"features: has 20,001 entries; at most 20,000 are read"),
        ({"type": "LineString", "coordinates": [[1, 2], [3]]}, r"coordinates\[1\]: has 1 number; \[longitude, lat"),
        (
            {"type": "LineString", "coordinates": [[1, 2], [3, 195]]},
            r"coordinates\[1\]: 195, 3 is not a latitude within -90 and 90",
        ),
        (
            {"type": "LineString", "coordinates": [[1, 2], [-37.8, 144.9]]},
            r"coordinates\[1\]: 144\.9, -37\.8 is not a latitude .*; they look swapped: GeoJSON is \[longitude, lat",
        ),
        (
            {"type": "LineString", "coordinates": [[385_000, 6_671_000 + at] for at in range(86)]},
            r"coordinates\[0\]: 6671000, 385000 is not .*; they look like metres of a projection \(and 85 more of the "
            r"kind, the last at coordinates\[85\]\)$",
        ),
        (
            {"type": "LineString", "coordinates": [[1, 2], [3, "x"]]},
            r"coordinates\[1\]: 3, 'x' are not numbers",
        ),
        (
            '{"type": "LineString", "coordinates": [[1, 2], [1e999, 2]]}',
            r"coordinates\[1\]: inf is not a finite number",
        ),
        ({"type": "LineString", "coordinates": [[1, 2], 3]}, r"coordinates\[1\]: 3 is not a list"),
        (with_crs("EPSG:3857"), r"crs\.properties\.name: 'EPSG:3857' is not latitude and longitude .*ogr2ogr -t_srs"),
        (with_crs(4326), r"crs\.properties\.name: 4326 is not latitude and longitude"),
        (
            with_crs("IAU_2015:30110"),
            r"'IAU_2015:30110' is not latitude and longitude of .* the Moon \(IAU_2015:30100\)",
        ),
        (with_crs("IAU_2015:49901"), r"'IAU_2015:49901' is not latitude and longitude of .* Mars \(IAU_2015:49900\)"),
        (LINE | {"crs": {"type": "link", "properties": {"href": "x"}}}, r"crs\.properties\.href: 'x' is not latitude"),
        (
            {"type": "MultiLineString", "coordinates": [LINE["coordinates"], LINE["coordinates"]]},
            r"has 2 lines \(coordinates\[0\], coordinates\[1\]\)",
        ),
        ({"type": "MultiLineString", "coordinates": [[[1, 2], [3, 4]], [[3, 4]]]}, r"coordinates\[1\]: has 1 position"),
        (
            {"type": "MultiLineString", "coordinates": [[[1, 2]] * 15_000] * 2},
            r"coordinates\[0\]: has 30,000 positions; at most 20,000",
        ),
        (
            {"type": "MultiLineString", "coordinates": [[[1, 2], "x"], [[3], []]]},
            r"coordinates\[0\]\[1\]: 'x' is not a list",
        ),
    ],
)
def test_what_is_no_path_is_refused_one_problem_a_cause(tmp_path: Path, content: object, problem: str) -> None:
    with pytest.raises(MissionError, match=problem) as caught:
        imported(tmp_path, content, "line.geojson")
    assert "\n" not in str(caught.value).partition("\n  ")[0]


def test_collections_in_collections_have_a_limit(tmp_path: Path) -> None:
    content = LINE
    for _ in range(21):
        assert imported(tmp_path, content, "line.geojson").legs == ON_THE_WAY
        content = {"type": "GeometryCollection", "geometries": [content]}
    for _ in range(2):
        content = {"type": "GeometryCollection", "geometries": [content]}
    with pytest.raises(MissionError, match="is a GeometryCollection more than 20 deep in others"):
        imported(tmp_path, content, "line.geojson")


@pytest.mark.parametrize("east", [180.0001, -179.9999])
def test_a_line_goes_on_across_the_antimeridian(tmp_path: Path, east: float) -> None:
    whole = {"type": "LineString", "coordinates": [[179.9999, 0], [180, 0], [east, 0]]}
    cut = {"type": "MultiLineString", "coordinates": [[[179.9999, 0], [180, 0]], [[east - 1e-4, 0], [east, 0]]]}
    mirrored = {"type": "LineString", "coordinates": [[-179.9999, 0], [-180, 0], [-180.0001, 0]]}
    assert imported(tmp_path, whole, "line.geojson").legs == [(11.13, 0.0), (22.26, 0.0)]
    assert imported(tmp_path, cut, "line.geojson").legs == [(11.13, 0.0), (22.26, 0.0)]
    assert imported(tmp_path, mirrored, "line.geojson").legs == [(-11.13, 0.0), (-22.26, 0.0)]


def test_a_line_across_a_country_is_refused(tmp_path: Path) -> None:
    line = {"type": "LineString", "coordinates": [[8.0, 47.0], [8.0, 47.1]]}
    with pytest.raises(MissionError, match=r"far\.geojson: spans 11\.1 km; the local frame is for at most 10 km"):
        imported(tmp_path, line, "far.geojson")


def test_a_swapped_line_far_from_its_origin_is_told_the_order(tmp_path: Path) -> None:
    swapped = {"type": "LineString", "coordinates": [[47.3977, 8.5456], [47.3977, 8.5457]]}
    with pytest.raises(
        MissionError, match=r"some .* km away .*\n  GeoJSON is \[longitude, latitude\]: see that they are"
    ):
        imported(tmp_path, swapped, "swapped.geojson", origin=(47.3977, 8.5456))
