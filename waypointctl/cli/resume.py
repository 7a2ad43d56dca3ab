"""`waypointctl run --resume`: continue a killed flight from its log."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from waypointctl.display_text import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from waypointctl.replay.resume import Unfinished

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
    from waypointctl.replay.resume import unfinished
    from waypointctl.task.plugins import load_plugins

    with unfinished(path, load_plugins(plugins)) as flight:
        if flight is None:
            return _say_complete(path, json=json)
        return _continue(flight, rate, console=console, json=json)


def _continue(flight: Unfinished, rate: float | None, *, console: bool, json: bool) -> int:
    from waypointctl.cli.flight_answer import report_flight
    from waypointctl.cli.flight_view import flight_view
    from waypointctl.cli.interruption import interruption
    from waypointctl.replay.contents import platform_differences
    from waypointctl.replay.resume import Interrupted, go_on

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
        with (
            interruption() as interrupted,
            flight_view(mission, rate, interrupted, console=console) as view,
        ):
            result = go_on(flight, again=view.learn, watch=view.sink, interrupted=interrupted, console=view.console)
    except Interrupted:
        typer.echo(f"interrupted before the end of {log} was reached; that log is unchanged", err=True)
        return _INTERRUPTED
    summary = view.watch.flight.summary()
    return report_flight(mission.name, result, summary, time.monotonic() - began_s, json=json)


def _say_complete(path: Path, *, json: bool) -> int:
    """Say that there is nothing to do; return the exit code of the flight, as when it was flown."""
    from waypointctl.cli.flight_answer import report_flight
    from waypointctl.flight.outcome import FlightResult
    from waypointctl.log.opening import PART
    from waypointctl.replay.flight_log import FlightLog

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
