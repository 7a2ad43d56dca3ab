"""A flight at the command line: how it is shown and paced, and what is answered when it is over."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import typer

from waypointctl.cli.console import console as people
from waypointctl.cli.console import is_live
from waypointctl.cli.log_place import say_missing
from waypointctl.cli.program import interruption
from waypointctl.cli.tui.playback import Watch, paced, watch
from waypointctl.cli.tui.prompt import Prompt
from waypointctl.cli.tui.screens import ConsoleScreen
from waypointctl.cli.tui.summary import print_flight
from waypointctl.cli.tui.terminal import TypedLines
from waypointctl.display_text import printable
from waypointctl.flight.header import setting_of
from waypointctl.flight.operator.console import LineSource
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.flight.outcome import FlightResult
from waypointctl.flight.sink import Sink
from waypointctl.log.opening import PART
from waypointctl.mission.mission import Mission
from waypointctl.replay.contents import platform_differences
from waypointctl.replay.flight_log import FlightLog
from waypointctl.replay.resume import Interrupted, Unfinished, go_on, unfinished
from waypointctl.replay.summary import FlightSummary, Plain, summary_json
from waypointctl.task.plugins import load_plugins
from waypointctl.units import seconds


@dataclass(frozen=True, slots=True)
class FlightView:
    """What a flight is connected to."""

    watch: Watch  # what shows it
    sink: Sink  # takes each message as it happens, no sooner than it is time for it
    learn: Sink  # takes messages that were shown before, without a word
    console: LineSource | None  # where a person's commands come from, if there is a person


@contextmanager
def flight_view(
    mission: Mission, rate: float | None, interrupted: Callable[[], bool], *, console: bool
) -> Iterator[FlightView]:
    """Yield the view of a flight on stderr: live, as lines, or with a console.

    Args:
        mission: what is flown.
        rate: simulated seconds in a second; without it as fast as it goes, with a console in real time.
        interrupted: whether the end was requested.
        console: whether a person commands too.
    """
    plan = planned_waypoints(mission)
    if console:
        shown_on = people(stderr=True)
        typed = TypedLines(echo=is_live(shown_on))
        setting = setting_of(mission)
        screen = ConsoleScreen(shown_on, mission.name, plan, setting) if typed.is_terminal else None
        with Prompt(mission, plan, typed, rate, interrupted, screen) as prompt:
            yield FlightView(prompt, prompt, prompt.learn, prompt)
        return
    with watch(mission.name, plan, setting_of(mission)) as view:
        if rate is not None:
            view.say(f"at {rate:g} times real time")
        sink = view if rate is None else paced(view, rate, interrupted)
        yield FlightView(view, sink, lambda message: view.flight(message), None)


EXIT_CODES: Final = {"success": 0, "failure": 1, "interrupted": 130}


def report_flight(
    mission: str, result: FlightResult, summary: FlightSummary, wall_s: float | None, *, json: bool
) -> int:
    """Print the outcome of a flight, with the JSON object if `--json` is given; return the exit code.

    Args:
        mission: its name.
        result: of the flight.
        summary: of the flight.
        wall_s: the wall time that it took; None for one that was flown before, of which only the object is printed.
        json: print the object on stdout, and the rest on stderr.
    """
    if wall_s is not None:
        say_missing(result)
        print_flight(summary, result, wall_s, stderr=json)
    if json:
        sys.stdout.write(f"{json_text(facts(mission, result, summary))}\n")
    return EXIT_CODES.get(summary.outcome, 1)


def facts(mission: str, result: FlightResult, summary: FlightSummary) -> Plain:
    """Return the facts of a mission's flight; fields are only ever added.

    `waypoints_reached` counts those known to the operator; `summary` is what `replay --json` has of the log.
    """
    return {
        "mission": mission,
        "outcome": result.outcome,
        "reason": result.reason,
        "waypoints_reached": result.waypoints_reached,
        "waypoints_total": result.waypoints_total,
        "sim_time_s": seconds(result.sim_time_ns),
        "seed": result.seed,
        "log": str(result.log),
        "log_sha256": result.log_sha256,
        "pictures": result.pictures,
        "summary": summary_json(summary, mission),
    }


_INTERRUPTED = 130


def resume_flight(path: Path, rate: float | None, plugins: Sequence[Path], *, console: bool, json: bool) -> int:
    """Continue a flight; return the exit code.

    Args:
        path: of the log, or of its .part.
        rate: simulated seconds in a second, from where the log ends.
        plugins: Python files, which are executed.
        console: whether a person types commands, from where the log ends.
        json: whether the answer is one JSON object.
    """
    with unfinished(path, load_plugins(plugins)) as flight:
        if flight is None:
            return _say_complete(path, json=json)
        return _continue(flight, rate, console=console, json=json)


def _continue(flight: Unfinished, rate: float | None, *, console: bool, json: bool) -> int:

    mission, log = flight.contents.mission, printable(flight.log.path)
    if console and not flight.events.had_console:
        raise typer.BadParameter("--console: the flight was started without a console, and cannot continue with one.")
    if others := platform_differences(flight.log):
        note = "it continues only if the flight is bit for bit the same here; the finished log will name this program"
        typer.echo(f"note: {log} was made elsewhere ({printable(', '.join(others))}): {note}", err=True)
    typer.echo(
        f"{mission.name}: repeated up to {_end_s(flight):.2f} s from the log; the flight continues from there", err=True
    )
    began_s = time.monotonic()
    try:
        with interruption() as interrupted, flight_view(mission, rate, interrupted, console=console) as view:
            result = go_on(flight, again=view.learn, watch=view.sink, interrupted=interrupted, console=view.console)
    except Interrupted:
        typer.echo(f"interrupted before the end of {log} was reached; that log is unchanged", err=True)
        return _INTERRUPTED
    summary = view.watch.flight.summary()
    return report_flight(mission.name, result, summary, time.monotonic() - began_s, json=json)


def _say_complete(path: Path, *, json: bool) -> int:
    """Say that there is nothing to do; return the exit code of the flight, as when it was flown."""
    path = path.with_name(path.name.removesuffix(PART))
    log = FlightLog.open(path)
    summary = log.summary
    typer.echo(printable(f"{path} is complete: {summary.headline}"), err=True)
    reached, total, ended_ns = summary.known, len(summary.waypoints), summary.ended_ns
    seed, pictures = int(log.metadata["seed"]), log.count("/camera")
    result = FlightResult(summary.outcome, summary.reason, reached, total, ended_ns, ended_ns, seed, pictures)
    return report_flight(log.mission_name, result.logged(path), summary, None, json=json)


def _end_s(flight: Unfinished) -> float:
    return (flight.log.end_ns or 0) / 1e9


def json_text(found: Plain) -> str:
    """Return JSON; a NaN or infinite number is null."""
    return json.dumps(_finite(found), indent=2, allow_nan=False)


def _finite(value: object) -> object:
    match value:
        case float():
            return value if math.isfinite(value) else None
        case dict():
            return {key: _finite(item) for key, item in value.items()}
        case list():
            return [_finite(item) for item in value]
        case _:
            return value
