"""`waypointctl run --resume`: a flight that was killed goes on from its log."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from waypointctl.display_text import printable

if TYPE_CHECKING:
    from waypointctl.replay.resume import Unfinished

_INTERRUPTED = 130


@dataclass(frozen=True, slots=True)
class Resumption:
    """What was asked for.

    Attributes:
        log: the log, or its .part.
        rate: simulated seconds in a second, from where the log ends.
        console: whether a person commands on, from where the log ends.
        json: whether the answer is one JSON object.
    """

    log: Path
    rate: float | None
    console: bool
    json: bool


def refuse_beside_resume(given: Mapping[str, object]) -> None:
    """Refuse what would make another flight of it; None is what was not given."""
    names = [name for name, value in given.items() if value is not None]
    if names:
        problem = (
            f"{', '.join(names)} cannot be given with --resume: mission, policy, seed and place are the log's own."
        )
        raise typer.BadParameter(problem)


def resume_flight(asked: Resumption) -> int:
    """Go on with a flight; return the exit code."""
    from waypointctl.replay.resume import unfinished

    with unfinished(asked.log) as flight:
        if flight is None:
            return _say_complete(asked)
        return _go_on(flight, asked)


def _go_on(flight: Unfinished, asked: Resumption) -> int:
    from waypointctl.cli.flight_answer import EXIT_CODES, answer
    from waypointctl.cli.flight_view import flight_view
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.pictures import say_missing
    from waypointctl.cli.tui.summary import print_flight
    from waypointctl.replay.contents import platform_differences
    from waypointctl.replay.resume import Interrupted, go_on

    mission, log = flight.contents.mission, printable(flight.log.path)
    if asked.console and not flight.events.had_console:
        raise typer.BadParameter("--console: the flight had none, and with one it would be another flight.")
    if others := platform_differences(flight.log):
        note = "it is gone on with only if it is the same flight here, and the finished log will name this program"
        typer.echo(f"note: {log} was made elsewhere ({printable(', '.join(others))}): {note}", err=True)
    typer.echo(
        f"{mission.name}: repeated up to {_end_s(flight):.2f} s from the log; the flight continues from there", err=True
    )
    began_s = time.monotonic()
    try:
        with (
            interruption() as interrupted,
            flight_view(mission, asked.rate, interrupted, console=asked.console) as view,
        ):
            result = go_on(flight, again=view.learn, watch=view.sink, interrupted=interrupted, console=view.console)
    except Interrupted:
        typer.echo(f"interrupted before it was where {log} ends; that log is as it was", err=True)
        return _INTERRUPTED
    say_missing(result)
    summary = view.watch.flight.summary()
    print_flight(summary, result, time.monotonic() - began_s, stderr=asked.json)
    if asked.json:
        sys.stdout.write(answer(mission.name, result, summary))
    return EXIT_CODES[result.outcome]


def _say_complete(asked: Resumption) -> int:
    """Say that there is nothing to do; return the exit code of the flight, as when it was flown."""
    from waypointctl.cli.flight_answer import EXIT_CODES, answer
    from waypointctl.flight.outcome import FlightResult
    from waypointctl.log.opening import PART
    from waypointctl.replay.flight_log import FlightLog

    path = asked.log.with_name(asked.log.name.removesuffix(PART))
    log = FlightLog.open(path)
    summary = log.summary
    typer.echo(printable(f"{path} is complete: {summary.headline}"), err=True)
    if asked.json:
        reached, total, ended_ns = summary.known, len(summary.waypoints), summary.ended_ns
        seed, pictures = int(log.metadata["seed"]), log.count("/camera")
        result = FlightResult(summary.outcome, summary.reason, reached, total, ended_ns, ended_ns, seed, pictures)
        sys.stdout.write(answer(log.mission_name, result.logged(path), summary))
    return EXIT_CODES.get(summary.outcome, 1)


def _end_s(flight: Unfinished) -> float:
    return (flight.log.end_ns or 0) / 1e9
