"""Many missions in one command: each flown and logged, a table at the end, and a report for CI servers.

The report is JUnit XML, a suite with a case a mission, as CI servers read it (Jenkins' junit-10.xsd). Times in it are
simulated seconds, as its property `clock` states; it holds no wall-clock time.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from waypointctl.cli.console import console
from waypointctl.cli.flight_view import facts, json_text
from waypointctl.cli.log_place import claimed, say_missing
from waypointctl.cli.program import interruption
from waypointctl.cli.tui.tables import flights_table
from waypointctl.display_text import printable, printable_lines
from waypointctl.errors import InputError
from waypointctl.flight.fly import fly
from waypointctl.flight.header import setting_of
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.flight.outcome import FlightResult
from waypointctl.mission.files import MissionFile
from waypointctl.paths import refuse_other_content, refuse_unwritable_file, write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.replay.summary import Plain
from waypointctl.replay.summary_builder import FlightSummaryBuilder
from waypointctl.task.plugins import Plugin, load_plugins
from waypointctl.units import seconds

SUITE: Final = "waypointctl run"
_WORDS: Final = {
    "success": "succeeded",
    "failure": "failed",
    "interrupted": "interrupted",
    "error": "invalid file",
    "skipped": "not flown",
}

LoadMission = Callable[[Path], "MissionFile"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of a mission file."""

    path: Path  # of the file
    verdict: str  # of its flight; "error" if it could not be flown, "skipped" if the run was interrupted before
    reason: str  # why
    mission: str = ""  # its name
    result: FlightResult | None = None  # of its flight, if there was one
    facts: Plain = field(default_factory=dict)  # of its flight, as --json has them

    @property
    def word(self) -> str:
        """The verdict as people read it."""
        return _WORDS[self.verdict]


def run_many(
    paths: Sequence[Path],
    load: LoadMission,
    policy: Path | None,
    plugins: tuple[Path, ...],
    out: Path | None,
    *,
    force: bool,
    junit: Path | None,
    as_json: bool,
) -> int:
    """Fly missions one after the other; return the exit code.

    Args:
        paths: of the missions.
        load: reads a mission file, and refuses one whose policy is not there.
        policy: the policy that drives the robot, in place of the one in each mission.
        plugins: Python files, which are executed.
        out: the log, where there is only one mission.
        force: replace it.
        junit: where the JUnit report goes.
        as_json: print one JSON object.
    """
    if junit is not None:
        refuse_unwritable_file(junit, "the report")
        refuse_other_content(junit, b"<?xml", "an XML file")  # such as the next mission
    policies: dict[Path, LoadedPolicy] = {}
    executed = load_plugins(plugins)
    outcomes: list[Outcome] = []
    with interruption() as interrupted:
        for path in paths:
            if interrupted():
                outcomes.append(Outcome(path, "skipped", "not flown: interrupted before it started"))
                continue
            try:
                outcome = _fly(path, load(path), policy, policies, executed, out, interrupted, force=force)
                line = printable(f"{outcome.verdict}: {outcome.reason}")
            except InputError as error:
                outcome, line = Outcome(path, "error", str(error)), str(error)
            outcomes.append(outcome)
            place = f"{printable(path)}:"
            print(line if line.startswith(place) else f"{place} {line}", file=sys.stderr, flush=True)
    if junit is not None:
        write_whole(junit, junit_xml(outcomes), "the report")
    _print_table(outcomes, stderr=as_json)
    if as_json:
        records = [_record(outcome) for outcome in outcomes]
        sys.stdout.write(f"{json_text(records[0] if len(records) == 1 else {'missions': records})}\n")
    return _exit_code({outcome.verdict for outcome in outcomes})


def _fly(
    path: Path,
    file: MissionFile,
    policy: Path | None,
    policies: dict[Path, LoadedPolicy],
    plugins: tuple[Plugin, ...],
    out: Path | None,
    interrupted: Callable[[], bool],
    *,
    force: bool,
) -> Outcome:

    name, flight = file.mission.name, FlightSummaryBuilder(planned_waypoints(file.mission), setting_of(file.mission))
    folder = policy or file.policy_path.resolve()
    if folder not in policies:
        policies[folder] = load_policy(policy or file.policy_path)
    with claimed(name, out, force=force) as log:
        result = fly(file, policies[folder], flight, log=log, pictures=True, plugins=plugins, interrupted=interrupted)
    say_missing(result)
    return Outcome(path, result.outcome, result.reason, name, result, facts(name, result, flight.summary()))


def _record(outcome: Outcome) -> Plain:
    """Return an outcome as --json has it."""
    return {"file": str(outcome.path)} | (outcome.facts or {"outcome": outcome.verdict, "reason": outcome.reason})


def _exit_code(verdicts: set[str]) -> int:
    if verdicts & {"interrupted", "skipped"}:
        return 130
    return 2 if "error" in verdicts else int("failure" in verdicts)


def _print_table(outcomes: Sequence[Outcome], *, stderr: bool) -> None:

    people = console(stderr=stderr)
    people.print()
    people.print(flights_table(outcomes))
    people.print()
    counts = Counter(outcome.word for outcome in outcomes)
    people.print(", ".join(f"{count} {_plural(word, count)}" for word, count in counts.items()))


def _plural(word: str, count: int) -> str:
    return f"{word}s" if word == _WORDS["error"] and count != 1 else word


def junit_xml(outcomes: Sequence[Outcome]) -> bytes:
    """Return the JUnit report of some missions; a flight that was interrupted is an error there."""
    tags = Counter(_tag(outcome) for outcome in outcomes)
    counts = {"tests": len(outcomes), "failures": tags["failure"], "errors": tags["error"]}
    numbers = {name: str(count) for name, count in counts.items()}
    time = f"{sum(map(_time_s, outcomes)):.3f}"
    root = ElementTree.Element("testsuites", {"name": SUITE, **numbers, "time": time})
    suite = ElementTree.SubElement(
        root, "testsuite", {"name": SUITE, **numbers, "skipped": str(tags["skipped"]), "time": time}
    )
    properties = ElementTree.SubElement(suite, "properties")
    ElementTree.SubElement(properties, "property", {"name": "clock", "value": "simulation"})
    for outcome in outcomes:
        _add(suite, outcome)
    ElementTree.indent(root)
    report: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return report + b"\n"


def _add(suite: ElementTree.Element, outcome: Outcome) -> None:
    attributes = {"classname": SUITE, "name": printable(outcome.path), "time": f"{_time_s(outcome):.3f}"}
    element, tag, text = ElementTree.SubElement(suite, "testcase", attributes), _tag(outcome), outcome.reason
    if outcome.verdict == "interrupted":
        text = f"interrupted: {text}"
    message = {"message": printable(text.partition("\n")[0])}
    if tag == "skipped":
        ElementTree.SubElement(element, tag, message)
    elif tag != "success":
        ElementTree.SubElement(element, tag, {"type": tag, **message}).text = printable_lines(text)
    if (result := outcome.result) is not None:
        output = f"mission {outcome.mission}, seed {result.seed}\n{printable(result.log or '')}\n"
        output += f"sha256 {result.log_sha256}\n"
        ElementTree.SubElement(element, "system-out").text = printable_lines(output)


def _tag(outcome: Outcome) -> str:
    return "error" if outcome.verdict == "interrupted" else outcome.verdict


def _time_s(outcome: Outcome) -> float:
    return 0.0 if outcome.result is None else seconds(outcome.result.sim_time_ns)
