"""The importers, and the one that reads a file: a format is recognised by its content, whatever the file is called."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

from waypointctl.errors import MissionError
from waypointctl.importers.csv_table import CSV
from waypointctl.importers.geojson import GEOJSON
from waypointctl.importers.gpx import GPX
from waypointctl.importers.importer import ImportedMission, Importer, ImportOptions
from waypointctl.importers.kml import KML
from waypointctl.importers.qgroundcontrol import QGC_PLAN
from waypointctl.importers.report import Report, text_of
from waypointctl.importers.wpl import WPL
from waypointctl.mission.file_kind import FileKind, kind_of
from waypointctl.mission.yaml_source import read_source
from waypointctl.paths import command_for_mission

IMPORTERS: Final[tuple[Importer, ...]] = (QGC_PLAN, WPL, GEOJSON, GPX, KML, CSV)

MAX_BYTES: Final = 10 << 20
_OF_MANY: Final = (".json", ".txt")  # suffixes of several formats
_READ: Final = (
    "QGroundControl plans, waypoint files (QGC WPL 110), GeoJSON, GPX, KML, and CSV with named columns are read"
)


def read_imported(path: Path) -> ImportedMission:
    """Return the mission in another tool's file.

    Raises:
        MissionError: the file does not exist, is in no format that is read, or has an error.
    """
    source = read_source(path, MissionError, MAX_BYTES)
    suffix = path.suffix.lower()
    importer = next((each for each in IMPORTERS if each.recognises(source)), None)
    importer = importer or _by_suffix(source, suffix)
    if importer is None:
        raise _unknown(source, path)
    imported = importer.read(source, ImportOptions(str(path), path.stem))
    if suffix not in importer.suffixes and any(suffix in each.suffixes for each in IMPORTERS):
        return replace(imported, remarks=(*imported.remarks, f"is {importer.name} by its content, and read as that"))
    return imported


def _by_suffix(source: bytes, suffix: str) -> Importer | None:
    """Return the importer of a suffix for a file whose content does not show its format."""
    if kind_of(source) not in (None, FileKind.JSON) or suffix in _OF_MANY:
        return None
    return next((each for each in IMPORTERS if suffix in each.suffixes), None)


def _unknown(source: bytes, path: Path) -> MissionError:
    kind = kind_of(source)
    if kind is not None:
        has_hint = kind not in (FileKind.JSON, FileKind.HDTN_PLAN, FileKind.XML, FileKind.BINARY)
        return MissionError(kind.value, where=str(path), hint=None if has_hint else f"{_READ}.")
    text_of(source, Report(str(path)))
    hint = command_for_mission(str(path)) or "See docs/import.md for what each looks like."
    return MissionError(f"is not a file that can be imported: {_READ}", where=str(path), hint=hint)
