"""`waypointctl validate`: are these mission files fit to be flown, if not, why not, and what to expect of them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from waypointctl.cli.options import policy_named
from waypointctl.display_text import printable
from waypointctl.paths import folder_fault

if TYPE_CHECKING:
    from waypointctl.flight.forecast.forecast import Forecast
    from waypointctl.mission.files import MissionFile
    from waypointctl.mission.problems import Problem


@dataclass(frozen=True, slots=True)
class Warned:
    """Something to think about, and where the file says so: "file:line:column", or the file alone."""

    kind: str
    place: str
    path: str
    text: str


@dataclass(frozen=True, slots=True)
class _Checked:
    """What checking a file came to: a mission with what to expect of it, or problems."""

    path: Path
    file: MissionFile | None
    problems: tuple[Problem, ...]
    forecast: Forecast | None = None
    warnings: tuple[Warned, ...] = ()
    policy: Path | None = None  # who is expected to fly it


def validate(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION.yaml...", help="Mission files.")],
    policy: Annotated[
        Path | None,
        typer.Option(
            parser=policy_named,
            metavar="POLICY",
            help="Expect this policy, a folder or a name, to fly, not the mission's.",
            show_default=False,
        ),
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 if there is a warning.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check mission files, list every problem, and say what to expect without flying: how it ends, how long it takes.

    A file without problems is OK, or FAILS where the mission can be flown and is expected to fail. Exits with 2 if
    there is a problem; what may go wrong are warnings.
    """
    _refuse_missing(policy)
    checked = [_check(path, policy) for path in missions]
    good = all(result.file is not None for result in checked)
    if as_json:
        typer.echo(json.dumps({"ok": good, "missions": [_record(result) for result in checked]}))
    else:
        for result in checked:
            _show(result)
    if not good:
        raise typer.Exit(2)
    if strict and any(result.warnings for result in checked):
        raise typer.Exit(1)


def _refuse_missing(policy: Path | None) -> None:
    from waypointctl.errors import PolicyError
    from waypointctl.mission.policy_name import policies_there_are

    if policy is not None and (fault := folder_fault(policy)):
        raise PolicyError(fault, where=str(policy), hint=policies_there_are(policy.name))


def _check(path: Path, policy: Path | None = None) -> _Checked:
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
    file = MissionFile(reading.model, source, path)
    who = policy or file.policy_path
    found = _forecast(file, who)
    missing = () if policy is not None else _policy_warnings(file)
    return _Checked(path, file, (), found, (*missing, *_warnings(file, found)), who)


def _forecast(file: MissionFile, policy: Path) -> Forecast:
    from waypointctl.evaluation.walking_speed import walking_speed
    from waypointctl.flight.forecast.forecast import forecast

    return forecast(file.mission, walking_speed(policy))


def _policy_warnings(file: MissionFile) -> tuple[Warned, ...]:
    from waypointctl.mission.policy_name import policies_there_are

    if not folder_fault(file.policy_path):
        return ()
    text = f"there is no folder {file.policy_path}. {policies_there_are(file.mission.policy)}"
    return (Warned("policy", file.policy_place, "policy", text),)


def _warnings(file: MissionFile, found: Forecast) -> Iterator[Warned]:
    """Yield what may go wrong, in the order of the file's lines."""
    from waypointctl.mission.written import written_at
    from waypointctl.mission.yaml_tree import read_tree

    tree = read_tree(file.source)
    placed = [(written_at(tree, finding.path), finding) for finding in found.findings]
    for (path, mark), finding in sorted(placed, key=lambda each: (each[0][1].line, each[0][1].column)):
        yield Warned(finding.kind, f"{file.path}:{mark.line}:{mark.column}", path, finding.text)


def _show(result: _Checked) -> None:
    from waypointctl.cli.tui.expectation import expectation
    from waypointctl.cli.tui.link import link_text

    for problem in result.problems:
        typer.echo(str(problem))
    if result.file is None:
        return
    mission = result.file.mission
    count = mission.num_legs
    word = "OK" if result.forecast is None or result.forecast.own.succeeds else "FAILS"
    typer.echo(
        f"{word} {printable(result.path)}: {mission.name}, {count} waypoint{'s' if count > 1 else ''}, "
        f"{mission.path_length_m():.1f} m, {printable(link_text(mission.link))}, autonomy {mission.autonomy}"
    )
    if result.forecast is not None:
        typer.echo(f"   {expectation(result.forecast)}")
    for warning in result.warnings:
        typer.echo(f"warning: {printable(f'{warning.place}: {warning.path}: {warning.text}')}", err=True)


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
    mission, found, policy = result.file.mission, result.forecast, result.policy
    assert found is not None
    assert policy is not None
    return record | {
        "name": mission.name,
        "waypoints": mission.num_legs,
        "path_length_m": mission.path_length_m(),
        "link": mission.link.model_dump(),
        "autonomy": mission.autonomy,
        "policy": str(policy),
        "policy_found": folder_fault(policy) is None,
        "speed": asdict(found.speed),
        "expected_time_s": found.own.time_s,
        "expected_time_is_lower_bound": found.is_lower_bound,
        "expected_success": found.own.succeeds,
        "expected_failure": found.own.fails,
        "probability": found.chance,
        "expected": [asdict(each) for each in found.expected],
        "not_counted": list(found.not_counted),
        "warnings": [asdict(warning) for warning in result.warnings],
    }
