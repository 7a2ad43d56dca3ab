from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.errors import MissionError
from waypointctl.mission.file_kind import FileKind, kind_of
from waypointctl.mission.files import load_mission

LFS = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 12345\n"


@pytest.mark.parametrize(
    ("source", "kind"),
    [
        (LFS, FileKind.LFS_POINTER),
        (b"PK\x03\x04\x14\x00", FileKind.ZIP),
        (b"PK\x05\x06" + bytes(18), FileKind.ZIP),
        (b"\x1f\x8b\x08\x00", FileKind.GZIP),
        ("name: n".encode("utf-16"), FileKind.UTF_16),
        ("name: n".encode("utf-16-be"), FileKind.BINARY),
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", FileKind.BINARY),
        (b"<!DOCTYPE html>\n<html>", FileKind.HTML),
        (b"\n <HTML lang='en'>", FileKind.HTML),
        (b"\xef\xbb\xbf<?xml version='1.0'?>\n<!-- <kml> --><gpx version='1.1'>", FileKind.GPX),
        (b"<kml:kml xmlns:kml='http://www.opengis.net/kml/2.2'>", FileKind.KML),
        (b"<?xml version='1.0'?><!DOCTYPE gpx [<!ENTITY a 'b'>]><gpx/>", FileKind.GPX),
        (b"<mission/>", FileKind.XML),
        (b'{"version": 1, "fileType": "Plan", "mission": {}}', FileKind.QGC_PLAN),
        (b' {"features": [], "type" : "FeatureCollection"}', FileKind.GEOJSON),
        (b'{"type":"MultiLineString","coordinates":[]}', FileKind.GEOJSON),
        (b'{"contacts":[]}', FileKind.HDTN_PLAN),
        (b'{"name": "n"}', FileKind.JSON),
        (b"QGC WPL 110\r\n", FileKind.WPL),
        (b"name: n\npolicy: p\n", None),
        (b"", None),
        (b"< 3", None),
    ],
)
def test_a_file_is_what_its_content_says(source: bytes, kind: FileKind | None) -> None:
    assert kind_of(source) is kind


@pytest.mark.parametrize("source", [LFS, b"PK\x03\x04", b"<html>", b'{"fileType": "Plan"}', b"QGC WPL 110\n"])
def test_a_mission_that_is_something_else_is_one_problem(tmp_path: Path, source: bytes) -> None:
    path = tmp_path / "m.yaml"
    path.write_bytes(source)
    kind = kind_of(source)
    assert kind is not None
    with pytest.raises(MissionError) as caught:
        load_mission(path)
    assert str(caught.value) == f"{path}:1:1: {kind.value}"


@given(st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
def test_any_bytes_have_a_kind_or_none(source: bytes) -> None:
    assert kind_of(source) is None or isinstance(kind_of(source), FileKind)
