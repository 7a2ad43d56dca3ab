"""`waypointctl study`: many flights, to answer a question that one does not."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from waypointctl.cli.options import PluginFiles, number_to, parsed, policy_named, whole
from waypointctl.display_text import printable
from waypointctl.errors import InputError
from waypointctl.mission.policy_name import FLAGSHIP

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from waypointctl.mission.files import MissionFile
    from waypointctl.studies.case import DelayCase
    from waypointctl.studies.delay import DelayStudy

_LONGEST_RTT_S: Final = 86_400.0
_MOST_SEEDS: Final = 10_000
# Routes, round trips [s] and flights of each kind.
_USUAL: Final = ("two-point,ten-point", "0,0.4,2.56,5,10,40", 20)
_QUICK: Final = ("short", "0,0.4,2.56", 2)

study = typer.Typer(help="Fly many missions and compare them.", no_args_is_help=True)


@study.callback()
def _group() -> None:
    """Fly many missions and compare them."""


@study.command("delay")
def delay(
    policy: Annotated[Path, parsed("POLICY", policy_named, "The policy, a folder or a name.")] = FLAGSHIP,  # type: ignore[assignment]  # a name, which the parser makes a folder of
    seeds: Annotated[
        int | None,
        whole(1, _MOST_SEEDS, "Flights per route, round trip and autonomy, one per seed.", show_default="20"),
    ] = None,
    seed: Annotated[int, whole(0, 2**31, "The first seed.")] = 0,
    rtt: Annotated[
        str | None, typer.Option(metavar="S,S,...", help="Round-trip times, in s.", show_default="0,0.4,2.56,5,10,40")
    ] = None,
    autonomy: Annotated[
        str, typer.Option(metavar="NAME,...", help="Autonomies to compare.")
    ] = "mission,waypoint,short_range_goal,short_range_goal-continuous,joint",
    route: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,...",
            help="two-point, ten-point, short, or mission files.",
            show_default="two-point,ten-point",
        ),
    ] = None,
    think: Annotated[
        float | None,
        parsed("S", number_to(86_400), "Think time of the operator, in s.", show_default="the mission's own"),
    ] = None,
    find_joint_limit: Annotated[
        bool, typer.Option("--find-joint-limit", help="Also fly joint at round trips of 0, 20, ... 260 ms.")
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Fly a small study to try: one short route, 2 seeds.")] = False,
    jobs: Annotated[int, whole(0, 1024, "Flights at a time; 0: one per core.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="The folder of the results.", show_default="runs/study-delay")
    ] = None,
    keep_logs: Annotated[bool, typer.Option("--keep-logs", help="Also keep the log of each flight.")] = False,
    plugin: PluginFiles = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the tables go to stderr.")] = False,
) -> None:
    """Fly routes at several round-trip times and autonomies.

    Success, time, distance and falls are compared.

    The study varies the delay, the autonomy, the seed and the time limits of a mission. It keeps jitter, losses, rate,
    windows, think time, faults and rules on board. It refuses a mission with a part that it cannot keep.

    Finished flights stay in the folder; the same command continues an interrupted study. Exit with 0 when all flights
    are finished, whatever their outcomes; 130 if interrupted.
    """
    from waypointctl.policy.bundle import load_policy
    from waypointctl.studies.delay import study_delay

    cases, fine, routes = _cases(route, rtt, autonomy, seed, seeds, quick=quick, find_joint_limit=find_joint_limit)
    folder = out or Path("runs/study-delay-quick" if quick else "runs/study-delay")
    options: dict[str, Any] = {
        "think_s": think,
        "processes": jobs,
        "keep_logs": keep_logs,
        "plugins": tuple(plugin or ()),
    }
    found = _flown(partial(study_delay, load_policy(policy), routes, cases, fine, folder, **options), folder)
    _show(found, folder, stderr=json)
    if json:
        sys.stdout.write(f"{found.model_dump_json(indent=2)}\n")


def _cases(
    route: str | None,
    rtt: str | None,
    autonomy: str,
    seed: int,
    seeds: int | None,
    *,
    quick: bool,
    find_joint_limit: bool,
) -> tuple[list[DelayCase], list[DelayCase], dict[str, MissionFile]]:
    """Return the cases of the study, those of its finer sweep, and its routes, by the options."""
    from waypointctl.studies.case import autonomies_of, fine_grid, grid, load_routes, refuse_what_is_not_kept

    usual_route, usual_rtts, usual_seeds = _QUICK if quick else _USUAL
    routes = load_routes(_parts(route or usual_route))
    names = autonomies_of(_parts(autonomy))
    refuse_what_is_not_kept(routes)
    rtts_s = rtts_of(rtt) if rtt else _possible(rtts_of(usual_rtts), routes)
    trials = range(seed, seed + (seeds or usual_seeds))
    return grid(routes, names, rtts_s, trials), fine_grid(routes, trials) if find_joint_limit else [], routes


def _flown(fly: Callable[..., DelayStudy | None], folder: Path) -> DelayStudy:
    """Fly a study with a progress bar; an interruption ends the program with 130."""
    from waypointctl.cli.main import INTERRUPTED
    from waypointctl.cli.program import interruption
    from waypointctl.cli.rehearsing import flights_progress

    with interruption() as interrupted, flights_progress() as show:
        found = fly(progress=show, interrupted=interrupted)
    if found is None:
        typer.echo(
            f"interrupted; the finished flights are in {printable(folder)}, and the same command continues", err=True
        )
        raise typer.Exit(INTERRUPTED)
    return found


def rtts_of(text: str) -> tuple[float, ...]:
    """Return round trips [s], ascending, from a list such as "0,0.4,2.56".

    Raises:
        InputError: one is not a number of seconds, too long, or there twice.
    """
    hint = "Give seconds, separated by commas, as in --rtt 0,0.4,2.56."
    rtts_s = []
    for part in _parts(text):
        try:
            rtt_s = float(part)
        except ValueError:
            raise InputError(f"--rtt: {part!r} is not a number", hint=hint) from None
        if not 0 <= rtt_s <= _LONGEST_RTT_S:
            raise InputError(f"--rtt: {part} is not within 0 and {_LONGEST_RTT_S:g} s", hint=hint)
        rtts_s.append(rtt_s)
    if len(set(rtts_s)) < len(rtts_s):
        raise InputError(f"--rtt: {text!r} has a value twice", hint=hint)
    return tuple(sorted(rtts_s))


def _possible(rtts_s: tuple[float, ...], routes: Mapping[str, MissionFile]) -> tuple[float, ...]:
    """Return those of the usual round trips that the routes' links can have; print those left out."""
    from waypointctl.studies.case import least_round_trip_s

    least_s = max(least_round_trip_s(file.mission.link) for file in routes.values())
    if short := [f"{rtt_s:g}" for rtt_s in rtts_s if rtt_s < least_s]:
        left_out = f"left out: round trips of {', '.join(short)} s; link.jitter needs {least_s:g} s or more"
        typer.echo(left_out, err=True)
    return tuple(rtt_s for rtt_s in rtts_s if rtt_s >= least_s) or (least_s,)


def _parts(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _show(found: DelayStudy, folder: Path, *, stderr: bool) -> None:
    from waypointctl.cli.console import console
    from waypointctl.cli.tui.tables import GridView
    from waypointctl.studies.delay import PICTURE, TABLES, VALUES
    from waypointctl.studies.tables import tables

    people = console(stderr=stderr)
    for grid in tables(found):
        people.print(GridView(grid, ("--json", str(folder / TABLES))))
        people.print()
    typer.echo(f"{printable(folder / PICTURE)}: the picture; the tables in {TABLES} and {VALUES}", err=stderr)
