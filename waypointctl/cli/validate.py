"""`waypointctl validate`: are these mission files right, what may go wrong, and how do rehearsals go."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from waypointctl.cli.options import PluginFiles, parsed, policy_named, whole
from waypointctl.display_text import printable
from waypointctl.paths import folder_fault

if TYPE_CHECKING:
    from waypointctl.flight.checks import Finding
    from waypointctl.mission.files import MissionFile
    from waypointctl.mission.problems import Problem
    from waypointctl.studies.rehearsal import Rehearsal


@dataclass(frozen=True, slots=True)
class _Checked:
    """What checking a file has found: problems, or a mission with warnings."""

    path: Path
    file: MissionFile | None
    problems: tuple[Problem, ...]
    policy: Path | None = None  # that flies it
    warnings: tuple[dict[str, str], ...] = ()  # as --json has them
    prevented: bool = False  # whether the mission cannot succeed
    rehearsals: tuple[Rehearsal, ...] = ()  # the first under the mission's own autonomy

    @property
    def fails(self) -> bool:
        return self.prevented or bool(self.rehearsals and not self.rehearsals[0].successes)

    @property
    def is_good(self) -> bool:
        return not self.problems and not self.fails

    @property
    def is_doubtful(self) -> bool:
        return bool(self.warnings or (self.rehearsals and self.rehearsals[0].failures))


def validate(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION.yaml...", help="Mission files.")],
    policy: Annotated[
        Path | None,
        parsed("POLICY", policy_named, "Check for this policy, a folder or a name, instead of the mission's."),
    ] = None,
    rehearse: Annotated[int | None, whole(1, 10_000, "Fly each mission N times, with N seeds.")] = None,
    autonomy: Annotated[
        str | None, typer.Option(metavar="NAME,...|all", help="Also rehearse under these autonomies.")
    ] = None,
    jobs: Annotated[int, whole(0, 1024, "Rehearsals at a time; 0: one per core.")] = 0,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 1 if there is a warning or a failed rehearsal.")
    ] = False,
    plugin: PluginFiles = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check mission files: list every problem, and warn of risks.

    Nothing is flown without --rehearse.

    --rehearse flies each mission headless, without a log, and prints successes, times, where and why flights failed,
    and what the link did not deliver. The first flight has the mission's own seed.

    A mission is OK, or FAILS if it cannot succeed or no rehearsal under its own autonomy does. Exit with 0 if all are
    OK, 1 if one fails, 2 if a file, its robot or its policy has problems or the policy was not made for the robot, 130
    if it was interrupted.
    """
    if rehearse is None and autonomy is not None:
        raise typer.BadParameter("needs --rehearse N.", param_hint="--autonomy")
    _refuse_missing(policy)
    plugins = tuple(plugin or ())
    checked = [_check(path, policy, plugins) for path in missions]
    if rehearse is not None:
        checked = _rehearsed(checked, rehearse, autonomy, jobs, plugins)
    if as_json:
        good = all(result.is_good for result in checked)
        typer.echo(json.dumps({"ok": good, "missions": [_record(result) for result in checked]}))
    else:
        for result in checked:
            _show(result)
    if any(result.problems for result in checked):
        raise typer.Exit(2)
    if any(result.fails or (strict and result.is_doubtful) for result in checked):
        raise typer.Exit(1)


def _rehearsed(
    checked: list[_Checked], flights: int, autonomy: str | None, jobs: int, plugins: tuple[Path, ...]
) -> list[_Checked]:
    """Return what checking has found, with the rehearsals of the missions without problems."""
    from waypointctl.cli.rehearsing import rehearse_files

    sound = {at: result for at, result in enumerate(checked) if result.file is not None and not result.problems}
    files = [(result.file, result.policy) for result in sound.values() if result.file and result.policy]
    found = dict(zip(sound, rehearse_files(files, flights, autonomy, jobs, plugins), strict=True))
    return [replace(result, rehearsals=found.get(at, ())) for at, result in enumerate(checked)]


def _refuse_missing(policy: Path | None) -> None:
    from waypointctl.errors import PolicyError
    from waypointctl.mission.policy_name import policies_there_are

    if policy is not None and (fault := folder_fault(policy)):
        raise PolicyError(fault, where=str(policy), hint=policies_there_are(policy.name))


def _check(path: Path, policy: Path | None, plugins: tuple[Path, ...]) -> _Checked:
    from waypointctl.errors import MissionError
    from waypointctl.evaluation.mean_speed import mean_speed_of
    from waypointctl.flight.checks.check import cannot_succeed, check_mission, robot_and_policy_problems
    from waypointctl.mission.files import MissionFile, beside, examine_mission
    from waypointctl.mission.problems import Problem
    from waypointctl.mission.yaml_source import read_source

    try:
        source = read_source(path, MissionError)
    except MissionError as error:
        return _Checked(path, None, (Problem(str(path), 0, 0, "", error.problem),))
    reading = examine_mission(source, str(path), beside(path))
    if reading.model is None:
        return _Checked(path, None, reading.problems)
    file = MissionFile(reading.model, source, path)
    flown_by = policy or file.policy_path
    findings = check_mission(file.mission, mean_speed_of(flown_by))
    prevented = cannot_succeed(file.mission, findings)
    problems = robot_and_policy_problems(file, flown_by, plugins)
    return _Checked(path, file, problems, flown_by, tuple(_warnings(file, findings)), prevented)


def _warnings(file: MissionFile, findings: tuple[Finding, ...]) -> Iterator[dict[str, str]]:
    """Yield the findings with their places, in the order of the file's lines."""
    from waypointctl.mission.yaml_source import written_at
    from waypointctl.mission.yaml_tree import read_tree

    tree = read_tree(file.source)
    placed = [(written_at(tree, finding.path), finding) for finding in findings]
    for (path, mark), finding in sorted(placed, key=lambda each: (each[0][1].line, each[0][1].column)):
        place = f"{file.path}:{mark.line}:{mark.column}"
        yield {"kind": finding.kind, "place": place, "path": path, "text": finding.text}


def _show(result: _Checked) -> None:
    from waypointctl.cli.tui.formatting import link_text

    for problem in result.problems:
        typer.echo(str(problem))
    if result.file is not None and not result.problems:
        mission = result.file.mission
        count = f"{mission.num_legs} waypoint{'s' if mission.num_legs > 1 else ''}"
        what = f"{mission.name}, {count}, {mission.path_length_m():.1f} m, {printable(link_text(mission.link))}"
        word = "FAILS" if result.fails else "OK"
        typer.echo(f"{word} {printable(result.path)}: {what}, autonomy {mission.autonomy}")
    if result.rehearsals:
        from waypointctl.cli.rehearsing import rehearsal_lines

        for line in rehearsal_lines(result.rehearsals):
            typer.echo(f"   {printable(line)}")
    for warning in result.warnings:
        typer.echo(f"warning: {printable('{place}: {path}: {text}'.format(**warning))}", err=True)


def _record(result: _Checked) -> dict[str, Any]:
    """Return a result as --json has it; the mission's entries are there only where it is one."""
    record: dict[str, Any] = {
        "file": str(result.path),
        "ok": result.is_good,
        "problems": [
            {"file": it.where, "line": it.line, "column": it.column, "path": it.path, "problem": it.text}
            for it in result.problems
        ],
    }
    if result.file is None:
        return record
    mission = result.file.mission
    return record | {
        "name": mission.name,
        "waypoints": mission.num_legs,
        "path_length_m": mission.path_length_m(),
        "link": mission.link.model_dump(),
        "autonomy": mission.autonomy,
        "policy": str(result.policy),
        "fails": result.fails,
        "warnings": list(result.warnings),
        "rehearsals": [rehearsal.record() for rehearsal in result.rehearsals],
    }
