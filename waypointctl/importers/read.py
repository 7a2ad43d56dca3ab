"""Read a file of another tool, whatever it is called: what it is, is known by its content."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, TypeAlias

from waypointctl.errors import MissionError
from waypointctl.importers.csv_table import is_table, read_csv
from waypointctl.importers.geojson import read_geojson
from waypointctl.importers.gpx import read_gpx
from waypointctl.importers.kml import read_kml
from waypointctl.importers.qgroundcontrol import read_plan
from waypointctl.importers.report import Report
from waypointctl.importers.survey import Survey
from waypointctl.importers.text_source import text_of
from waypointctl.importers.wpl import read_wpl
from waypointctl.mission.file_kind import FileKind, kind_of
from waypointctl.mission.yaml_source import read_source
from waypointctl.paths import command_for_mission

Read: TypeAlias = Callable[[bytes, Report, str], Survey]

MAX_BYTES: Final = 10 << 20
_READERS: Final[dict[FileKind, tuple[Read, str, tuple[str, ...]]]] = {
    FileKind.QGC_PLAN: (read_plan, "a QGroundControl plan", (".plan",)),
    FileKind.WPL: (read_wpl, "a waypoint file (QGC WPL)", (".waypoints", ".txt")),
    FileKind.GEOJSON: (read_geojson, "GeoJSON", (".geojson", ".json")),
    FileKind.GPX: (read_gpx, "GPX", (".gpx",)),
    FileKind.KML: (read_kml, "KML", (".kml",)),
}
_READ: Final = (
    "QGroundControl plans, waypoint files (QGC WPL 110), GeoJSON, GPX, KML, and CSV with named columns are read"
)


def read_survey(path: Path) -> Survey:
    """Return what a file of another tool says of a mission.

    Raises:
        MissionError: the file does not exist, is not of a kind that is read, or has an error.
    """
    source = read_source(path, MissionError, MAX_BYTES)
    report = Report(str(path))
    kind, suffix = kind_of(source), path.suffix.lower()
    if kind == FileKind.JSON and suffix in (".plan", ".geojson"):
        kind = FileKind.QGC_PLAN if suffix == ".plan" else FileKind.GEOJSON
    if kind in _READERS:
        read, what, suffixes = _READERS[kind]
        survey = read(source, report, path.stem)
        known = {each for _, _, names in _READERS.values() for each in names} | {".csv", ".tsv"}
        if suffix in known - set(suffixes):
            return replace(survey, remarks=(*survey.remarks, f"is {what} by its content, and read as that"))
        return survey
    if kind is not None:
        says_what_to_do = kind not in (FileKind.JSON, FileKind.HDTN_PLAN, FileKind.XML, FileKind.BINARY)
        raise MissionError(kind.value, where=str(path), hint=None if says_what_to_do else f"{_READ}.")
    text = text_of(source, report)
    if is_table(text) or suffix in (".csv", ".tsv"):
        return read_csv(source, report, path.stem)
    hint = command_for_mission(str(path)) or "See docs/import.md for what each looks like."
    raise MissionError(f"is not a file that can be imported: {_READ}", where=str(path), hint=hint)
