"""Rehearsals at the command line: progress bar and text output."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final, TypeAlias

import typer

from waypointctl.cli.console import console, is_live
from waypointctl.cli.main import INTERRUPTED
from waypointctl.cli.program import interruption
from waypointctl.cli.tui.formatting import MESSAGE_KINDS
from waypointctl.display_text import printable
from waypointctl.errors import InputError
from waypointctl.mission.files import MissionFile
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import load_policy
from waypointctl.studies.rehearsal import AUTONOMIES, Rehearsal, rehearse


def rehearse_files(
    files: Sequence[tuple[MissionFile, Path]],
    flights: int,
    autonomies: str | None,
    jobs: int,
    plugins: tuple[Path, ...] = (),
) -> list[tuple[Rehearsal, ...]]:
    """Rehearse missions, each with the policy in a folder; an interruption ends the program with 130.

    Args:
        files: the missions and their policies' folders.
        flights: of each mission and autonomy.
        autonomies: names separated by commas, or "all", to fly beside the mission's own; None for none.
        jobs: flights at a time; 0 for one a core.
        plugins: Python files, which are executed.
    """
    others = _autonomies(autonomies)
    policies = {folder: load_policy(folder) for folder in dict.fromkeys(folder for _, folder in files)}
    missions = [(file.mission, policies[folder]) for file, folder in files]

    def of(mission: Mission) -> list[str]:
        return list(dict.fromkeys((mission.autonomy, *others)))

    with interruption() as interrupted, flights_progress() as show:
        found = rehearse(missions, of, flights, jobs, show, interrupted, plugins)
    if found is None:
        typer.echo("interrupted", err=True)
        raise typer.Exit(INTERRUPTED)
    return [tuple(rehearsals) for rehearsals in found]


def dry_run(files: Sequence[MissionFile], policy: Path | None, plugins: tuple[Path, ...], *, as_json: bool) -> int:
    """Fly missions once each, without logs; print how they end and return the exit code.

    Args:
        files: the missions.
        policy: that flies them; None for each mission's own.
        plugins: Python files, which are executed.
        as_json: print one JSON object.
    """
    found = rehearse_files([(file, policy or file.policy_path) for file in files], 1, None, 0, plugins)
    if as_json:
        missions = [
            {"file": str(file.path), "mission": file.mission.name, "rehearsals": [each.record() for each in rehearsals]}
            for file, rehearsals in zip(files, found, strict=True)
        ]
        typer.echo(json.dumps({"missions": missions}))
    else:
        for file, rehearsals in zip(files, found, strict=True):
            typer.echo(f"{printable(file.path)}: {file.mission.name}")
            for line in rehearsal_lines(rehearsals):
                typer.echo(f"   {printable(line)}")
    return 0 if all(rehearsals[0].successes for rehearsals in found) else 1


def rehearsal_lines(rehearsals: Sequence[Rehearsal]) -> Iterator[str]:
    """Yield the rehearsals of a mission as lines."""
    width = max(len(rehearsal.autonomy) for rehearsal in rehearsals)
    for rehearsal in rehearsals:
        count, (low, high) = len(rehearsal.flights), rehearsal.wilson95
        rate = f"{rehearsal.successes} of {count} flights succeeded (95 % interval {low:.0%} to {high:.0%})"
        if count == 1:
            rate = rehearsal.flights[0].outcome
        yield f"{rehearsal.autonomy:{width}}  {rate}{_times(rehearsal.time_s, count)}"
        for cause, waypoint, flights, seed in rehearsal.failures:
            where = f", on the way to {waypoint}" if waypoint else ""
            yield f"  failed: {cause}{where}: {_count(flights, 'flight')}, the first with seed {seed}"
        for (way, what, why), messages, flights in rehearsal.undelivered:
            counts = f"{_count(messages, 'message')} in {_count(flights, 'flight')}"
            yield f"  not delivered {way}: {MESSAGE_KINDS.get(what, what)}, {why}: {counts}"


def _times(time_s: tuple[float, float, float] | None, count: int) -> str:
    if time_s is None:
        return ""
    median_s, shortest_s, longest_s = time_s
    if count == 1:
        return f" in {median_s:.1f} s"
    return f"; median time {median_s:.1f} s ({shortest_s:.1f} to {longest_s:.1f} s)"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"


def _autonomies(given: str | None) -> tuple[str, ...]:
    """Return the autonomies that an option names.

    Raises:
        InputError: there is none of a name.
    """
    if given is None or given == "all":
        return () if given is None else AUTONOMIES
    names = tuple(part.strip() for part in given.split(","))
    if unknown := [name for name in names if name not in AUTONOMIES]:
        choices = f"all, or of {', '.join(AUTONOMIES)}, separated by commas"
        raise InputError(f"--autonomy: {unknown[0]!r} is not an autonomy", hint=f"Give {choices}.")
    return names


Show: TypeAlias = Callable[[int, int], None]  # called with the number of flights that have ended, and of all

_LINES: Final = 10  # in all, where nothing can be drawn over


@contextmanager
def flights_progress() -> Iterator[Show]:
    """Yield a function that shows on stderr how many flights have ended."""
    people = console(stderr=True)
    if not is_live(people):
        yield _by_lines(people.print)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    with Progress(BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=people, transient=True) as bars:
        task = bars.add_task("")
        yield lambda ended, total: bars.update(task, completed=ended, total=total)


def _by_lines(say: Callable[[str], None]) -> Show:
    printed = -1

    def show(ended: int, total: int) -> None:
        nonlocal printed
        tenth = ended * _LINES // max(total, 1)
        if tenth > printed:
            printed = tenth
            say(f"{ended} of {total} flight{'s' * (total != 1)}")

    return show
