from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.geojson import read_geojson
from waypointctl.mission.survey import mission_text

LINE: dict[str, Any] = {
    "type": "LineString",
    "coordinates": [[8.5456, 47.3977], [8.5457, 47.3977, 5], [8.5457, 47.3978]],
}


def write(path: Path, content: object) -> Path:
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (LINE, "line"),
        ({"type": "Feature", "geometry": LINE, "properties": {"name": "the yard (2)"}}, "the-yard-2"),
        (
            {"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": LINE, "properties": None}]},
            "line",
        ),
    ],
)
def test_a_line_becomes_a_mission_from_its_first_position(tmp_path: Path, content: object, name: str) -> None:
    path = write(tmp_path / "line.geojson", content)
    mission = parse_mission(mission_text(read_geojson(path), "line.geojson", "p").encode(), "m")
    assert (mission.name, mission.start.position_m) == (name, (0, 0))
    (x1, y1), (x2, y2) = (waypoint.position_m for waypoint in mission.waypoints)
    assert (x1, y1) == pytest.approx((7.55, 0), abs=0.01)  # 75.5 km a degree of longitude at 47.4 degrees
    assert (x2, y2) == pytest.approx((7.55, 11.12), abs=0.01)


def test_an_origin_moves_the_frame_and_the_start(tmp_path: Path) -> None:
    survey = read_geojson(write(tmp_path / "line.json", LINE), (47.3976, 8.5456))
    mission = parse_mission(mission_text(survey, "line.json", "p").encode(), "m")
    assert mission.start.position_m == pytest.approx((0, 11.12), abs=0.01)


def test_what_it_says_of_itself(tmp_path: Path) -> None:
    text = mission_text(read_geojson(write(tmp_path / "line.json", LINE)), "line.json", "../p")
    assert text.startswith("# From 'line.json'. x is east and y is north of 47.3977000, 8.5456000.\n")
    assert "no place is off by more than 1 mm" in text
    assert 'policy: "../p"' in text


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", r":1:2: is not JSON"),
        ("[" * 100_000, "nested too deep"),
        ('{"type": NaN}', "NaN"),
        ([], "a list of 0 is not a mapping"),
        ({"type": "Point"}, r"type: 'Point' is not 'LineString' or 'Feature' or 'FeatureCollection'"),
        ({"type": "LineString"}, "'coordinates' is missing"),
        ({"type": "FeatureCollection", "features": []}, "has 0 lines; a mission is one LineString"),
        ({"type": "LineString", "coordinates": [[1, 2]]}, r"coordinates: has 1 position; 2 to 1001"),
        ({"type": "LineString", "coordinates": [[1, 2], [3]]}, r"coordinates\[1\]: has 1 number; \[longitude, lat"),
        (
            {"type": "LineString", "coordinates": [[1, 2], [3, 195]]},
            r"coordinates\[1\]\[1\]: 195 is not a number within -89",
        ),
        (
            {"type": "LineString", "coordinates": [[1, 2], [-37.8, 144.9]]},
            r"coordinates\[1\]: 144\.9 is no latitude: GeoJSON is \[longitude, latitude\], and these look swapped$",
        ),
        (
            {"type": "LineString", "coordinates": [[120, 95], [120.5, 2]]},
            r"coordinates\[0\]\[1\]: 95 is not a number within -89",
        ),
        (
            {"type": "LineString", "coordinates": [[1, 2], [3, "x"]]},
            r"coordinates\[1\]\[1\]: 'x' is not a finite number",
        ),
        ({"type": "LineString", "coordinates": [[1, 2], 3]}, r"coordinates\[1\]: 3 is not a list"),
        (LINE | {"crs": {"properties": {"name": "EPSG:3857"}}}, r"crs\.properties\.name: 'EPSG:3857' is not 'urn"),
    ],
)
def test_what_is_no_line_is_refused(tmp_path: Path, content: object, problem: str) -> None:
    with pytest.raises(MissionError, match=problem):
        read_geojson(write(tmp_path / "line.geojson", content))


def test_a_line_across_a_country_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "far.geojson", {"type": "LineString", "coordinates": [[8.0, 47.0], [8.0, 47.1]]})
    with pytest.raises(MissionError, match=r"far\.geojson: spans 11\.1 km; the local frame is for at most 10 km"):
        mission_text(read_geojson(path), "far.geojson", "p")


def test_a_swapped_line_far_from_its_origin_is_told_the_order(tmp_path: Path) -> None:
    swapped = {"type": "LineString", "coordinates": [[47.3977, 8.5456], [47.3977, 8.5457]]}
    survey = read_geojson(write(tmp_path / "swapped.geojson", swapped), (47.3977, 8.5456))
    with pytest.raises(MissionError, match=r"spans .* km;.*\n  GeoJSON is \[longitude, latitude\]: see that they are"):
        mission_text(survey, "swapped.geojson", "p")
