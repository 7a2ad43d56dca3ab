"""`waypointctl validate`: are these mission files fit to be flown, and if not, why not."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from waypointctl.paths import folder_fault

if TYPE_CHECKING:
    from waypointctl.mission.files import MissionFile
    from waypointctl.mission.problems import Problem


@dataclass(frozen=True, slots=True)
class _Checked:
    """What checking a file came to: a mission, or problems."""

    path: Path
    file: MissionFile | None
    problems: tuple[Problem, ...]


def validate(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION.yaml...", help="Mission files.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check mission files and list every problem.

    Exits with 2 if there is one.
    """
    checked = [_check(path) for path in missions]
    good = all(result.file is not None for result in checked)
    if as_json:
        typer.echo(json.dumps({"ok": good, "missions": [_record(result) for result in checked]}))
    else:
        for result in checked:
            _show(result)
    if not good:
        raise typer.Exit(2)


def _check(path: Path) -> _Checked:
    from waypointctl.errors import MissionError
    from waypointctl.mission.files import MissionFile
    from waypointctl.mission.problems import Problem
    from waypointctl.mission.references import beside, examine_mission
    from waypointctl.mission.yaml_source import read_source

    try:
        source = read_source(path, MissionError)
    except MissionError as error:
        return _Checked(path, None, (Problem(str(path), 0, 0, "", error.problem),))
    reading = examine_mission(source, str(path), beside(path))
    if reading.model is None:
        return _Checked(path, None, reading.problems)
    return _Checked(path, MissionFile(reading.model, source, path), ())


def _show(result: _Checked) -> None:
    from waypointctl.cli.view.link import link_text

    for problem in result.problems:
        typer.echo(str(problem))
    if result.file is None:
        return
    mission = result.file.mission
    count = len(mission.waypoints)
    typer.echo(
        f"OK {result.path}: {mission.name}, {count} waypoint{'s' if count > 1 else ''}, "
        f"{mission.path_length_m():.1f} m, {link_text(mission.link)}, autonomy {mission.autonomy}"
    )
    if folder_fault(result.file.policy_path):
        typer.echo(
            f"warning: {result.file.policy_place}: policy: there is no folder {result.file.policy_path}", err=True
        )


def _record(result: _Checked) -> dict[str, Any]:
    """Return a result as --json has it; the mission's entries are there only where it is one."""
    record: dict[str, Any] = {
        "file": str(result.path),
        "ok": result.file is not None,
        "problems": [
            {
                "file": problem.where,
                "line": problem.line,
                "column": problem.column,
                "path": problem.path,
                "problem": problem.text,
            }
            for problem in result.problems
        ],
    }
    if result.file is None:
        return record
    mission = result.file.mission
    return record | {
        "name": mission.name,
        "waypoints": len(mission.waypoints),
        "path_length_m": mission.path_length_m(),
        "link": mission.link.model_dump(),
        "autonomy": mission.autonomy,
        "policy": str(result.file.policy_path),
        "policy_found": folder_fault(result.file.policy_path) is None,
    }
