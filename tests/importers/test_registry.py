from __future__ import annotations

import copy
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.importers.plans import SHAPES, A, B, plan
from tests.importers.reading import imported, write
from tests.importers.test_geojson import LINE, POINT, POLYGON, collection, feature
from tests.importers.test_gpx_and_kml import LINE as KML_LINE
from tests.importers.test_gpx_and_kml import ROUTE, gpx, kml
from tests.importers.test_wpl import EAST, HOME, NORTH, wpl
from waypointctl.errors import MissionError
from waypointctl.importers.conversion import MAX_BYTES, read_imported

COLLECTION = collection(feature(LINE, name="n"), feature(POINT), feature(POLYGON), feature(None))
FORMATS = {
    "a QGroundControl plan": (json.dumps(plan(A, B)), (".plan",)),
    "a waypoint file (QGC WPL)": (wpl(HOME, NORTH, EAST), (".waypoints", ".txt")),
    "GeoJSON": (json.dumps(LINE), (".geojson", ".json")),
    "GPX": (gpx(ROUTE), (".gpx",)),
    "KML": (kml(KML_LINE), (".kml",)),
}


@pytest.mark.parametrize("what", FORMATS)
def test_a_file_is_read_as_what_it_is_whatever_it_is_called(tmp_path: Path, what: str) -> None:
    content, suffixes = FORMATS[what]
    known = {suffix for _, names in FORMATS.values() for suffix in names}
    for suffix in (*known, ".csv", ".dat", ""):
        found = imported(tmp_path, content, f"yard{suffix}")
        assert len(found.legs) == 2
        is_said = suffix not in suffixes and suffix not in (".dat", "")
        assert found.source.remarks == ((f"is {what} by its content, and read as that",) if is_said else ())


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        (
            "yard.plan",
            "version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
            "is a Git LFS pointer, .* 'git lfs pull'",
        ),
        ("yard.kmz", b"PK\x03\x04", r"is a ZIP archive \(\.kmz and \.xlsx are too\): unpack it"),
        ("yard.plan", b"\x1f\x8b\x08", "is a gzip archive: unpack it first"),
        (
            "yard.gpx",
            "<!DOCTYPE html><html>",
            "is an HTML page, such as a site shows for a file: download the file itself",
        ),
        ("yard.csv", "lat,lon\n".encode("utf-16"), "is not UTF-8 text but UTF-16: save it as UTF-8"),
        ("yard.shp", b"\x00\x00\x27\x0a", "is a binary file, not text"),
        ("cp.json", '{"contacts": []}', r"is JSON \(a contact plan of HDTN\)"),
        ("cp.plan", '{"contacts": []}', r"is JSON \(a contact plan of HDTN\)\n  QGroundControl plans"),
        ("yard.plan", "{}", "plan: 'fileType' is missing$"),
        ("yard.plan", '{"fileType": "Parameters"}', "plan: fileType: 'Parameters' is not 'Plan'$"),
        ("yard.json", '{"waypoints": []}', r"is JSON\n  QGroundControl plans, waypoint files"),
        ("yard.plan", '{"mission": {}}', "'fileType' is missing"),
        ("yard.txt", "1 2 3\n", "is not a file that can be imported: QGroundControl plans, waypoint files"),
        ("yard.yaml", "name: n\n", r"is not a file that can be .*\n  `waypointctl run .*` flies a mission"),
        ("yard.csv", "", "is empty"),
        ("yard.geojson", b'{"type": "Feature"}' + b" " * MAX_BYTES, "is larger than the 10 MiB that are read"),
    ],
)
def test_what_is_not_read_is_named_for_what_it_is(tmp_path: Path, name: str, content: object, problem: str) -> None:
    with pytest.raises(MissionError, match=problem) as caught:
        read_imported(write(tmp_path / name, content))
    assert str(caught.value).startswith(f"{tmp_path / name}: ")


def test_what_is_no_file_is_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.plan")
    for path, problem in {
        "pipe.plan": "is a named pipe, not a file",
        "missing.plan": "there is no such file",
        ".": "is a folder, not a file",
    }.items():
        with pytest.raises(MissionError, match=problem):
            read_imported(tmp_path / path)
    with pytest.raises(MissionError, match="is a device, not a file"):
        read_imported(Path("/dev/zero"))


SEEDS = [content.encode() for content, _ in FORMATS.values()] + [
    json.dumps(shape.plan).encode() for shape in SHAPES[::6]
] + [b"lat,lon,hold\n60,25,0\n60.0001,25,3\n"]  # fmt: skip
SCRAPS = [
    b"null",
    b"NaN",
    b"1e999",
    b"-1",
    b"[]",
    b"{}",
    b'"',
    b"9" * 400,
    b"\xff",
    b"\0",
    b"<",
    b"&x;",
    b"\n",
    b",",
    b"0",
]


@settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.sampled_from(SEEDS),
    places=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 12), st.sampled_from(SCRAPS)), max_size=4),
)
def test_a_damaged_file_is_imported_or_refused(
    tmp_path: Path, seed: bytes, places: list[tuple[float, int, bytes]]
) -> None:
    for share, length, scrap in places:
        at = int(share * len(seed))
        seed = seed[:at] + scrap + seed[at + length :]
    with suppress(MissionError):
        assert imported(tmp_path, seed, "damaged.dat").legs


VALUES: list[Any] = [
    *(
        None,
        True,
        0,
        -1,
        2,
        3,
        16,
        20,
        93,
        177,
        1.5,
        1e308,
        float("nan"),
        float("inf"),
        10**400,
        "",
        "60",
        "\ud800",
        "\x1b[31m",
    ),
    *([], {}, [[]], [None], [0, 0], [[60, 25]] * 3, {"a": 1}),
]


def places_in(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield where the values of a JSON text are."""
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in inner:
        yield from places_in(each, (*path, key))


@settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), seed=st.sampled_from([*(shape.plan for shape in SHAPES), LINE, COLLECTION]))
def test_a_file_with_wrong_values_is_imported_or_refused(tmp_path: Path, data: st.DataObject, seed: Any) -> None:
    content = copy.deepcopy(seed)
    for _ in range(data.draw(st.integers(1, 3))):
        *path, last = data.draw(st.sampled_from([place for place in places_in(content) if place]))
        part = content
        for key in path:
            part = part[key]
        part[last] = copy.deepcopy(data.draw(st.sampled_from(VALUES)))
    with suppress(MissionError):
        assert imported(tmp_path, content, data.draw(st.sampled_from(["a.plan", "a.geojson"]))).legs
