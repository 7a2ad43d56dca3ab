"""`waypointctl validate`: are these mission files right, and what may go wrong when they are flown."""

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
    from waypointctl.flight.checks.finding import Finding
    from waypointctl.mission.files import MissionFile
    from waypointctl.mission.problems import Problem


@dataclass(frozen=True, slots=True)
class _Warning:
    """A finding, and where the file says what it is about: "file:line:column", or the file alone."""

    kind: str
    place: str
    path: str
    text: str


@dataclass(frozen=True, slots=True)
class _Checked:
    """What checking a file has found: problems, or a mission with warnings."""

    path: Path
    file: MissionFile | None
    problems: tuple[Problem, ...]
    policy: Path | None = None  # that flies it
    warnings: tuple[_Warning, ...] = ()
    fails: bool = False  # whether the mission cannot succeed

    @property
    def is_good(self) -> bool:
        return not self.problems and not self.fails


def validate(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION.yaml...", help="Mission files.")],
    policy: Annotated[
        Path | None,
        typer.Option(
            parser=policy_named,
            metavar="POLICY",
            help="Check for this policy, a folder or a name, not the mission's.",
            show_default=False,
        ),
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 if there is a warning.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check mission files without flying them: list every problem, and warn of what may go wrong.

    A mission is OK, or FAILS if it cannot succeed. Exit with 0 if all are OK, 1 if one fails, 2 if a file has problems
    or its policy is not there.
    """
    _refuse_missing(policy)
    checked = [_check(path, policy) for path in missions]
    if as_json:
        good = all(result.is_good for result in checked)
        typer.echo(json.dumps({"ok": good, "missions": [_record(result) for result in checked]}))
    else:
        for result in checked:
            _show(result)
    if any(result.problems for result in checked):
        raise typer.Exit(2)
    if any(result.fails or (strict and result.warnings) for result in checked):
        raise typer.Exit(1)


def _refuse_missing(policy: Path | None) -> None:
    from waypointctl.errors import PolicyError
    from waypointctl.mission.policy_name import policies_there_are

    if policy is not None and (fault := folder_fault(policy)):
        raise PolicyError(fault, where=str(policy), hint=policies_there_are(policy.name))


def _check(path: Path, policy: Path | None) -> _Checked:
    from waypointctl.errors import MissionError
    from waypointctl.evaluation.walking_speed import walking_speed
    from waypointctl.flight.checks.check import cannot_succeed, check_mission
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
    flown_by = policy or file.policy_path
    findings = check_mission(file.mission, walking_speed(flown_by).mps)
    fails = cannot_succeed(file.mission, findings)
    return _Checked(path, file, _policy_problems(file, flown_by), flown_by, tuple(_warnings(file, findings)), fails)


def _policy_problems(file: MissionFile, policy: Path) -> tuple[Problem, ...]:
    from waypointctl.mission.policy_name import policies_there_are
    from waypointctl.mission.problems import Problem
    from waypointctl.mission.yaml_tree import read_tree

    if not folder_fault(policy):
        return ()
    mark = read_tree(file.source).values[("policy",)]
    text = f"there is no folder {policy}. {policies_there_are(file.mission.policy)}"
    return (Problem(str(file.path), mark.line, mark.column, "policy", text),)


def _warnings(file: MissionFile, findings: tuple[Finding, ...]) -> Iterator[_Warning]:
    """Yield the findings with their places, in the order of the file's lines."""
    from waypointctl.mission.written import written_at
    from waypointctl.mission.yaml_tree import read_tree

    tree = read_tree(file.source)
    placed = [(written_at(tree, finding.path), finding) for finding in findings]
    for (path, mark), finding in sorted(placed, key=lambda each: (each[0][1].line, each[0][1].column)):
        yield _Warning(finding.kind, f"{file.path}:{mark.line}:{mark.column}", path, finding.text)


def _show(result: _Checked) -> None:
    from waypointctl.cli.tui.link import link_text

    for problem in result.problems:
        typer.echo(str(problem))
    if result.file is not None and not result.problems:
        mission = result.file.mission
        count = f"{mission.num_legs} waypoint{'s' if mission.num_legs > 1 else ''}"
        what = f"{mission.name}, {count}, {mission.path_length_m():.1f} m, {printable(link_text(mission.link))}"
        word = "FAILS" if result.fails else "OK"
        typer.echo(f"{word} {printable(result.path)}: {what}, autonomy {mission.autonomy}")
    for warning in result.warnings:
        typer.echo(f"warning: {printable(f'{warning.place}: {warning.path}: {warning.text}')}", err=True)


def _record(result: _Checked) -> dict[str, Any]:
    """Return a result as --json has it; the mission's entries are there only where it is one."""
    record: dict[str, Any] = {
        "file": str(result.path),
        "ok": result.is_good,
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
        "waypoints": mission.num_legs,
        "path_length_m": mission.path_length_m(),
        "link": mission.link.model_dump(),
        "autonomy": mission.autonomy,
        "policy": str(result.policy),
        "fails": result.fails,
        "warnings": [asdict(warning) for warning in result.warnings],
    }
