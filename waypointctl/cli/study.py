"""`waypointctl study`: many flights, to answer a question that one does not."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from waypointctl.cli.options import not_negative, policy_named
from waypointctl.display_text import printable
from waypointctl.errors import InputError
from waypointctl.mission.policy_name import FLAGSHIP

if TYPE_CHECKING:
    from collections.abc import Mapping

    from waypointctl.mission.files import MissionFile
    from waypointctl.studies.delay import DelayStudy

_LONGEST_RTT_S: Final = 86_400.0
_MOST_SEEDS: Final = 10_000
_QUICK: Final = ("short", "0,0.4,2.56", 2)

study = typer.Typer(help="Fly many missions and compare them.", no_args_is_help=True)


@study.callback()
def _group() -> None:
    """Fly many missions and compare them."""


@study.command("delay")
def delay(
    policy: Annotated[
        Path, typer.Option(parser=policy_named, metavar="POLICY", help="The policy, a folder or a name.")
    ] = FLAGSHIP,  # type: ignore[assignment]  # a name, which the parser makes a folder of
    seeds: Annotated[
        int | None, typer.Option(min=1, max=_MOST_SEEDS, help="Flights of each kind.", show_default="20")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**31, help="The first of the seeds.")] = 0,
    rtt: Annotated[
        str | None, typer.Option(metavar="S,S,...", help="Round trips in s.", show_default="0,0.4,2.56,5,10,40")
    ] = None,
    autonomy: Annotated[
        str, typer.Option(metavar="NAME,...", help="Who decides what.")
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
        typer.Option(
            callback=not_negative,
            max=86_400,
            help="How long the operator thinks, in s.",
            show_default="the mission's own",
        ),
    ] = None,
    find_joint_limit: Annotated[
        bool, typer.Option("--find-joint-limit", help="Fly joint at round trips of 0, 20, ... 260 ms, too.")
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="A small one to try: a short route, 2 seeds.")] = False,
    jobs: Annotated[int, typer.Option(min=0, max=1024, help="Flights at a time; 0 is one a core.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="The folder for what comes of it.", show_default="runs/study-delay")
    ] = None,
    keep_logs: Annotated[bool, typer.Option("--keep-logs", help="Keep the log of each flight, too.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the tables go to stderr.")] = False,
) -> None:
    """Fly routes at several round trips, with more or less decided on board: success, time, distance, standing, falls.

    Of a mission the delay, the autonomy, the seed and the time limits are varied. The rest stays: jitter, losses, rate,
    windows, think time, faults and rules on board. A mission with anything that cannot stay is refused.

    What has been flown stays in the folder: the same command goes on where it was interrupted. Exit with 0 when all
    has been flown, whatever came of it; 130 if it was interrupted.
    """
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.tui.progress import flights_progress
    from waypointctl.policy.bundle import load_policy
    from waypointctl.studies.autonomy import autonomies_of
    from waypointctl.studies.delay import delay_cases
    from waypointctl.studies.route import load_routes
    from waypointctl.studies.run import study_delay
    from waypointctl.studies.varied_link import refuse_what_is_not_kept

    quick_route, quick_rtt, quick_seeds = _QUICK
    routes = load_routes(_parts(route or (quick_route if quick else "two-point,ten-point")))
    names = [one.name for one in autonomies_of(_parts(autonomy))]
    refuse_what_is_not_kept(routes)
    rtts_s = rtts_of(rtt) if rtt else _possible(rtts_of(quick_rtt if quick else "0,0.4,2.56,5,10,40"), routes)
    trials = range(seed, seed + (seeds or (quick_seeds if quick else 20)))
    cases, fine = delay_cases(list(routes), names, rtts_s, trials, find_joint_limit=find_joint_limit)
    folder = out or Path("runs/study-delay-quick" if quick else "runs/study-delay")
    loaded = load_policy(policy)
    with interruption() as interrupted, flights_progress() as show:
        found = study_delay(
            loaded,
            routes,
            cases,
            fine,
            folder,
            think_s=think,
            jobs=jobs or _cores(),
            keep_logs=keep_logs,
            watch=lambda progress: show(progress.flown, progress.total),
            interrupted=interrupted,
        )
    if found is None:
        typer.echo(f"interrupted; {printable(folder)} has what was flown, and the same command goes on", err=True)
        raise typer.Exit(130)
    _tell(found, folder, stderr=json)
    if json:
        sys.stdout.write(f"{found.model_dump_json(indent=2)}\n")


def rtts_of(text: str) -> tuple[float, ...]:
    """Return round trips [s], ascending, from a list such as "0,0.4,2.56".

    Raises:
        InputError: one is no number of seconds, too long, or there twice.
    """
    hint = "Give seconds, separated by commas, as in --rtt 0,0.4,2.56."
    rtts_s = []
    for part in _parts(text):
        try:
            rtt_s = float(part)
        except ValueError:
            raise InputError(f"--rtt: {part!r} is no number", hint=hint) from None
        if not 0 <= rtt_s <= _LONGEST_RTT_S:
            raise InputError(f"--rtt: {part} is not within 0 and {_LONGEST_RTT_S:g} s", hint=hint)
        rtts_s.append(rtt_s)
    if len(set(rtts_s)) < len(rtts_s):
        raise InputError(f"--rtt: {text!r} has one of them twice", hint=hint)
    return tuple(sorted(rtts_s))


def _possible(rtts_s: tuple[float, ...], routes: Mapping[str, MissionFile]) -> tuple[float, ...]:
    """Return those of the usual round trips that the routes' links can have; say which are left out."""
    from waypointctl.studies.varied_link import least_round_trip_s

    least_s = max(least_round_trip_s(file.mission.link) for file in routes.values())
    if short := [f"{rtt_s:g}" for rtt_s in rtts_s if rtt_s < least_s]:
        left_out = f"left out: round trips of {', '.join(short)} s; link.jitter needs {least_s:g} s or more"
        typer.echo(left_out, err=True)
    return tuple(rtt_s for rtt_s in rtts_s if rtt_s >= least_s) or (least_s,)


def _parts(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _cores() -> int:
    import os

    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _tell(found: DelayStudy, folder: Path, *, stderr: bool) -> None:
    from waypointctl.cli.console import console
    from waypointctl.cli.tui.grid_view import GridView
    from waypointctl.studies.files import PICTURE, TABLES, VALUES
    from waypointctl.studies.tables import tables

    people = console(stderr=stderr)
    for grid in tables(found):
        people.print(GridView(grid, ("--json", str(folder / TABLES))))
        people.print()
    typer.echo(f"{printable(folder / PICTURE)}: the picture; the tables in {TABLES} and {VALUES}", err=stderr)
