"""`waypointctl import`: other tools' plans as missions."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from waypointctl.display_text import printable, shell_word
from waypointctl.errors import InputError

if TYPE_CHECKING:
    from waypointctl.mission.local_frame import Place
    from waypointctl.mission.survey import Survey

_MAX_LATITUDE: Final = 89.0
_POLICY: Final = Path("policies/ant-waypoint")


def import_mission(
    file: Annotated[
        Path, typer.Argument(metavar="FILE.plan|FILE.geojson", help="A QGroundControl plan, or a GeoJSON line.")
    ],
    out: Annotated[Path | None, typer.Option(help="The mission file; stdout without it.", show_default=False)] = None,
    origin: Annotated[
        str | None,
        typer.Option(
            metavar="LAT,LON",
            help="Where x and y are 0, in degrees.",
            show_default="the planned home, or the line's start",
        ),
    ] = None,
    policy: Annotated[Path | None, typer.Option(help="Who walks: its folder.", show_default=str(_POLICY))] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the file that --out names.")] = False,
) -> None:
    """Make a mission of a plan: latitudes and longitudes become x (east) and y (north) in metres around an origin."""
    from waypointctl.mission.survey import mission_text
    from waypointctl.paths import refuse_unwritable_file, write_whole

    if out is not None:
        refuse_unwritable_file(out, "the mission")
        if out.exists() and not force:
            from waypointctl.errors import OutputError

            raise OutputError("is there already", where=str(out), mend="--force replaces it; or give another --out.")
    survey = _read(file, None if origin is None else origin_of(origin))
    folder = Path.cwd() if out is None else out.parent
    text = mission_text(survey, str(file), os.path.relpath(policy or _POLICY, folder))
    for note in survey.notes:
        typer.echo(f"left out: {printable(note)}", err=True)
    _warn_of_missing_policy(policy, file if out is None else out)
    if out is None:
        sys.stdout.write(text)
        return
    write_whole(out, text.encode(), "the mission")
    count = len(survey.stops)
    waypoints = f"{count} waypoint{'s' if count > 1 else ''}"
    check = f"`waypointctl validate {shell_word(out)}` says what to expect"
    typer.echo(f"{printable(out)}: {waypoints}; {check}")


def _warn_of_missing_policy(given: Path | None, mission: Path) -> None:
    from waypointctl.paths import folder_fault

    policy = given or _POLICY
    if fault := folder_fault(policy):
        named = "" if given else f" It is the default of --policy, relative to {Path.cwd()}: give --policy DIR."
        problem = f"{mission}: the policy {str(policy)!r} is not there: {fault}.{named}"
        typer.echo(f"warning: {printable(problem)}", err=True)


def origin_of(text: str) -> Place:
    """Return a place from "LAT,LON" in degrees.

    Raises:
        InputError: it is none.
    """
    mend = "Give latitude and longitude in degrees, as in --origin 47.3977,8.5456."
    try:
        latitude, longitude = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--origin: {text!r} is not two numbers with a comma between them", mend=mend) from None
    if not (-_MAX_LATITUDE <= latitude <= _MAX_LATITUDE and -180 <= longitude <= 180):
        problem = f"--origin: {text!r} is not a latitude within -89 and 89 and a longitude within -180 and 180"
        raise InputError(problem, mend=mend)
    return latitude, longitude


def _read(path: Path, origin: Place | None) -> Survey:
    from waypointctl.mission.geojson import read_geojson
    from waypointctl.mission.qgroundcontrol import read_plan

    suffix = path.suffix.lower()
    if suffix == ".plan":
        return read_plan(path, origin)
    if suffix in (".geojson", ".json"):
        return read_geojson(path, origin)
    problem = f"ends in {suffix!r}; .plan (QGroundControl) and .geojson are read" if suffix else "has no suffix"
    raise InputError(problem, where=str(path), mend="Name the file for what it is: .plan or .geojson.")
