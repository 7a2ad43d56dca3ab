"""Many missions in one command: each flown and logged, a table at the end, and a report for CI servers."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final

from waypointctl.display_text import printable
from waypointctl.errors import InputError
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.cli.junit import Case
    from waypointctl.flight.outcome import FlightResult
    from waypointctl.mission.files import MissionFile
    from waypointctl.policy.bundle import LoadedPolicy
    from waypointctl.replay.summary_json import Plain
    from waypointctl.task.plugins import Plugin

_NOT_FLOWN: Final = "not flown: interrupted before it started"
_WORDS: Final = {"success": "succeeded", "failure": "failed", "interrupted": "interrupted"}

LoadMission = Callable[[Path], "MissionFile"]


@dataclass(frozen=True, slots=True)
class Many:
    """The options of a run of several missions.

    Attributes:
        paths: their files.
        policy: the policy that drives the robot, in place of the one in each mission.
        plugins: Python files, which are executed.
        out: the log, where there is only one of them.
        force: replace it.
        junit: where the JUnit report goes.
        as_json: print one JSON object.
    """

    paths: tuple[Path, ...]
    policy: Path | None
    plugins: tuple[Path, ...]
    out: Path | None
    force: bool
    junit: Path | None
    as_json: bool


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of a mission file: a flight, why it could not be flown, or neither, after an interruption.

    Attributes:
        path: of the file.
        mission: its name.
        result: of its flight.
        facts: of its flight, as --json has them.
        problem: why it could not be flown.
    """

    path: Path
    mission: str = ""
    result: FlightResult | None = None
    facts: Plain = field(default_factory=dict)
    problem: str = ""


def run_many(many: Many, load: LoadMission) -> int:
    """Fly missions one after the other; return the exit code.

    Args:
        many: the options.
        load: reads a mission file, and refuses one whose policy is not there.

    Raises:
        OutputError: the report cannot be written.
    """
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.junit import junit_xml
    from waypointctl.paths import refuse_other_content, refuse_unwritable_file, write_whole
    from waypointctl.replay.summary_json import json_text

    if many.junit is not None:
        refuse_unwritable_file(many.junit, "the report")
        refuse_other_content(many.junit, b"<?xml", "an XML file")  # such as the next mission
    with interruption() as interrupted:
        outcomes = _fly_all(many, load, interrupted)
    if many.junit is not None:
        write_whole(many.junit, junit_xml([_case(outcome) for outcome in outcomes]), "the report")
    _print_table(outcomes, stderr=many.as_json)
    if many.as_json:
        records = [_record(outcome) for outcome in outcomes]
        sys.stdout.write(f"{json_text(records[0] if len(records) == 1 else {'missions': records})}\n")
    return _exit_code(outcomes)


def _fly_all(many: Many, load: LoadMission, interrupted: Callable[[], bool]) -> list[Outcome]:
    from waypointctl.task.plugins import load_plugins

    outcomes: list[Outcome] = []
    policies: dict[Path, LoadedPolicy] = {}
    plugins = load_plugins(many.plugins)
    for path in many.paths:
        if interrupted():
            outcomes.append(Outcome(path))
            continue
        try:
            outcome = _fly(path, many, load, policies, plugins, interrupted)
        except InputError as error:
            outcome = Outcome(path, problem=str(error))
        outcomes.append(outcome)
        line = outcome.problem or printable(_reason(outcome))
        print(f"{printable(path)}: {line}", file=sys.stderr, flush=True)
    return outcomes


def _fly(
    path: Path,
    many: Many,
    load: LoadMission,
    policies: dict[Path, LoadedPolicy],
    plugins: tuple[Plugin, ...],
    interrupted: Callable[[], bool],
) -> Outcome:
    from waypointctl.cli.flight_answer import facts
    from waypointctl.cli.log_place import claimed
    from waypointctl.cli.pictures import say_missing
    from waypointctl.flight.fly import fly
    from waypointctl.flight.header import setting_of
    from waypointctl.flight.operator.requests import planned_waypoints
    from waypointctl.policy.bundle import load_policy
    from waypointctl.replay.summary_builder import FlightSummaryBuilder

    file = load(path)
    name, flight = file.mission.name, FlightSummaryBuilder(planned_waypoints(file.mission), setting_of(file.mission))
    folder = many.policy or file.policy_path.resolve()
    if folder not in policies:
        policies[folder] = load_policy(many.policy or file.policy_path)
    with claimed(name, many.out, force=many.force) as log:
        result = fly(file, policies[folder], flight, log=log, pictures=True, plugins=plugins, interrupted=interrupted)
    say_missing(result)
    return Outcome(path, name, result, facts(name, result, flight.summary()))


def _reason(outcome: Outcome) -> str:
    if outcome.result is None:
        return _NOT_FLOWN
    return f"{outcome.result.outcome}: {outcome.result.reason}"


def _case(outcome: Outcome) -> Case:
    from waypointctl.cli.junit import Case

    name, result = str(outcome.path), outcome.result
    if outcome.problem:
        return Case(name, "error", outcome.problem, 0.0)
    if result is None:
        return Case(name, "skipped", _NOT_FLOWN, 0.0)
    output = (
        f"mission {outcome.mission}, seed {result.seed}\n{printable(result.log or '')}\nsha256 {result.log_sha256}\n"
    )
    flown_s = seconds(result.sim_time_ns)
    if result.outcome == "interrupted":
        return Case(name, "error", f"interrupted: {result.reason}", flown_s, output)
    return Case(name, "success" if result.outcome == "success" else "failure", result.reason, flown_s, output)


def _record(outcome: Outcome) -> Plain:
    """Return an outcome as --json has it."""
    if outcome.result is not None:
        return {"file": str(outcome.path), **outcome.facts}
    said = ("error", outcome.problem) if outcome.problem else ("skipped", _NOT_FLOWN)
    return {"file": str(outcome.path), "outcome": said[0], "reason": said[1]}


def _exit_code(outcomes: Sequence[Outcome]) -> int:
    results = [outcome.result.outcome for outcome in outcomes if outcome.result is not None]
    if "interrupted" in results or any(outcome.result is None and not outcome.problem for outcome in outcomes):
        return 130
    if any(outcome.problem for outcome in outcomes):
        return 2
    return 1 if "failure" in results else 0


def _print_table(outcomes: Sequence[Outcome], *, stderr: bool) -> None:
    from waypointctl.cli.console import console
    from waypointctl.cli.tui.tables import flights_table

    people = console(stderr=stderr)
    people.print()
    people.print(flights_table(outcomes))
    counts = {word: sum(_word(outcome) == word for outcome in outcomes) for word in map(_word, outcomes)}
    people.print()
    people.print(", ".join(f"{count} {word}" for word, count in counts.items()))


def _word(outcome: Outcome) -> str:
    if outcome.problem:
        return "broken"
    return "not flown" if outcome.result is None else _WORDS[outcome.result.outcome]
