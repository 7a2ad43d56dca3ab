"""`waypointctl import`: other tools' plans as missions."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from waypointctl.display_text import printable, shell_word
from waypointctl.errors import InputError
from waypointctl.mission.policy_name import FLAGSHIP, policies_there_are, policy_folder, policy_reference

if TYPE_CHECKING:
    from waypointctl.importers.local_frame import Place

_MAX_LATITUDE: Final = 90.0


def import_mission(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A QGroundControl plan, QGC WPL, GeoJSON, GPX, KML or CSV file.")
    ],
    out: Annotated[Path | None, typer.Option(help="The mission file; stdout without it.")] = None,
    origin: Annotated[
        str | None,
        typer.Option(
            metavar="LAT,LON",
            help="Where x and y are 0, in degrees.",
            show_default="the planned home, or the path's start",
        ),
    ] = None,
    body: Annotated[
        str | None,
        typer.Option(
            metavar="earth|moon|mars|RADIUS",
            help="What latitudes and longitudes are on; a radius with its unit.",
            show_default="the body in the file, else earth",
        ),
    ] = None,
    policy: Annotated[str, typer.Option(metavar="POLICY", help="The policy, a folder or a name.")] = FLAGSHIP,
    force: Annotated[bool, typer.Option("--force", help="Replace the file that --out names.")] = False,
) -> None:
    """Make a mission of another tool's plan.

    Latitudes and longitudes become x (east) and y (north) in metres around an origin.
    """
    from waypointctl.importers.conversion import mission_text, read_imported
    from waypointctl.importers.local_frame import body_of
    from waypointctl.paths import write_whole

    _refuse_taken(out, force)
    ground, center = (None if body is None else body_of(body)), (None if origin is None else origin_of(origin))
    imported = read_imported(file)
    if imported.is_metric and (ground or center):
        problem = "has x and y in metres; --origin and --body are for latitudes and longitudes"
        raise InputError(problem, where=str(file), hint="Leave them out.")
    text, placed = mission_text(imported, str(file), policy_reference(policy, out and out.parent), center, ground)
    for remark in imported.remarks:
        typer.echo(f"note: {printable(f'{file} {remark}')}", err=True)
    for note in placed.left_out:
        typer.echo(f"left out: {printable(note)}", err=True)
    _warn_of_missing_policy(policy, file if out is None else out)
    if out is None:
        sys.stdout.write(text)
        return
    write_whole(out, text.encode(), "the mission")
    count = len(placed.stops)
    waypoints = f"{count} waypoint{'s' if count > 1 else ''}"
    check = f"`waypointctl validate {shell_word(out)}` checks it"
    typer.echo(f"{printable(out)}: {waypoints}; {check}")


def _refuse_taken(out: Path | None, force: bool) -> None:
    from waypointctl.paths import refuse_unwritable_file

    if out is None:
        return
    refuse_unwritable_file(out, "the mission")
    if out.exists() and not force:
        from waypointctl.errors import OutputError

        raise OutputError("already exists", where=str(out), hint="Use --force to replace it, or give another --out.")


def _warn_of_missing_policy(policy: str, mission: Path) -> None:
    from waypointctl.paths import folder_fault

    if fault := folder_fault(policy_folder(policy)):
        problem = f"{mission}: the policy {policy!r} is not there: {fault}. {policies_there_are(policy)}"
        typer.echo(f"warning: {printable(problem)}", err=True)


def origin_of(text: str) -> Place:
    """Return a place from "LAT,LON" in degrees.

    Raises:
        InputError: it is none.
    """
    hint = "Give latitude and longitude in degrees, as in --origin 47.3977,8.5456."
    try:
        latitude, longitude = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--origin: {text!r} is not two numbers with a comma between them", hint=hint) from None
    if not (-_MAX_LATITUDE <= latitude <= _MAX_LATITUDE and -360 <= longitude <= 360):
        problem = f"--origin: {text!r} is not a latitude within -90 and 90 and a longitude within -360 and 360"
        raise InputError(problem, hint=hint)
    return latitude, longitude
