"""What a file is, by its content: files arrive under wrong names, or as a placeholder."""

from __future__ import annotations

import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from enum import Enum
from typing import Final

from waypointctl.display_text import shell_word


class FileKind(Enum):
    """A kind of file, with the predicate for messages."""

    LFS_POINTER = "is a Git LFS pointer, not the file itself: fetch that with 'git lfs pull'"
    ZIP = "is a ZIP archive (.kmz and .xlsx are too): unpack it, and give the file inside"
    GZIP = "is a gzip archive: unpack it first"
    UTF_16 = "is not UTF-8 text but UTF-16: save it as UTF-8"
    BINARY = "is a binary file, not text"
    HTML = "is an HTML page, such as a site shows for a file: download the file itself"
    GPX = "is a GPX file: `waypointctl import` makes a mission of it"
    KML = "is a KML file: `waypointctl import` makes a mission of it"
    XML = "is XML, and neither GPX nor KML"
    QGC_PLAN = "is a QGroundControl plan: `waypointctl import` makes a mission of it"
    GEOJSON = "is GeoJSON: `waypointctl import` makes a mission of it"
    WPL = "is a waypoint file (QGC WPL): `waypointctl import` makes a mission of it"
    HDTN_PLAN = "is JSON (a contact plan of HDTN)"
    JSON = "is JSON"


_LFS_POINTER: Final = b"version https://git-lfs.github.com/spec/"
_BEGINNINGS: Final = {
    _LFS_POINTER: FileKind.LFS_POINTER,
    b"PK\x03\x04": FileKind.ZIP,
    b"PK\x05\x06": FileKind.ZIP,
    b"\x1f\x8b": FileKind.GZIP,
    BOM_UTF16_LE: FileKind.UTF_16,
    BOM_UTF16_BE: FileKind.UTF_16,
}
_ROOTS: Final = {b"html": FileKind.HTML, b"gpx": FileKind.GPX, b"kml": FileKind.KML}
_ROOT: Final = re.compile(rb"<(?:!doctype\s+)?(?:[\w.-]+:)?([a-z][\w.-]*)", re.IGNORECASE)
_COMMENT: Final = re.compile(rb"<!--.*?-->", re.DOTALL)
_GEOMETRY: Final = rb'"(?:Feature(?:Collection)?|GeometryCollection|(?:Multi)?(?:Point|LineString|Polygon))"'
_JSON: Final = {
    re.compile(rb'"fileType"\s*:\s*"Plan"'): FileKind.QGC_PLAN,
    re.compile(rb'"type"\s*:\s*' + _GEOMETRY): FileKind.GEOJSON,
    re.compile(rb'"contacts"\s*:\s*\['): FileKind.HDTN_PLAN,
}
_LOOK_BYTES: Final = 8192  # of a file's beginning


def command_for_keys(data: object, path: str) -> str:
    """Return the problem text for a recipe or a suite given as a mission, known by its keys; empty for other data."""
    if not isinstance(data, dict) or "waypoints" in data:
        return ""
    file = shell_word(path)
    if "phases" in data:
        return f"this looks like a training recipe; use `waypointctl train {file}`"
    if "cases" in data or "courses" in data:
        return f"this looks like a suite; use `waypointctl eval --suite {file} POLICY`"
    return ""


def is_lfs_pointer(beginning: bytes) -> bool:
    """Tell whether a file that begins like this is a Git LFS pointer."""
    return beginning.startswith(_LFS_POINTER)


def kind_of(source: bytes) -> FileKind | None:
    """Return what a file is by its content, None for text of no kind in particular."""
    source = source.removeprefix(BOM_UTF8)
    beginning = source[:_LOOK_BYTES]
    kind = next((kind for magic, kind in _BEGINNINGS.items() if beginning.startswith(magic)), None)
    if kind is not None:
        return kind
    if b"\0" in beginning:
        return FileKind.BINARY
    text = beginning.lstrip()
    if text.startswith(b"QGC WPL"):
        return FileKind.WPL
    if text.startswith(b"<"):
        root = _ROOT.search(_COMMENT.sub(b"", text))
        return None if root is None else _ROOTS.get(root[1].lower(), FileKind.XML)
    if text.startswith((b"{", b"[")):
        return next((kind for pattern, kind in _JSON.items() if pattern.search(source)), FileKind.JSON)
    return None
