"""`waypointctl run`: fly a mission, watch it, log it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from waypointctl.cli.options import PluginFiles, parsed, policy_named, positive, whole

if TYPE_CHECKING:
    from waypointctl.mission.files import MissionFile


Missions = Annotated[
    list[Path] | None, typer.Argument(metavar="MISSION.yaml...", help="The mission file, or several to fly in turn.")
]
Policy = Annotated[
    Path | None, parsed("POLICY", policy_named, "Fly this policy, a folder or a name, instead of the mission's.")
]
Seed = Annotated[int | None, whole(0, 2**63 - 1, "Use this seed instead of the mission's.")]
Out = Annotated[Path | None, typer.Option(help="The log file.", show_default="logs/<mission>.mcap, or -2, -3, ...")]
Force = Annotated[bool, typer.Option("--force", help="Replace the file that --out names.")]
Rate = Annotated[
    float | None, parsed("X", positive, "Fly at X simulated seconds per second; without it, as fast as possible.")
]
Console = Annotated[
    bool,
    typer.Option(
        "--console", help="Read commands from the terminal during the flight, in real time unless --rate is given."
    ),
]
Resume = Annotated[Path | None, typer.Option(metavar="LOG", help="Continue the killed flight of this log.")]
Junit = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.xml", help="Write a JUnit report: one test case per mission, times in simulated seconds."
    ),
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Fly without a log, and print the outcome.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")]


def run(
    missions: Missions = None,
    policy: Policy = None,
    seed: Seed = None,
    out: Out = None,
    force: Force = False,
    rate: Rate = None,
    console: Console = False,
    resume: Resume = None,
    junit: Junit = None,
    dry_run: DryRun = False,
    plugin: PluginFiles = None,
    json: Json = False,
) -> None:
    """Fly a mission, or several, and log it. Exit with 0 for success, 1 for failure, 130 if it was interrupted.

    Of several each that can be flown is; the exit code is 2 if one of the files is broken.
    """
    flight: dict[str, object] = {"--out": out, "--force": force, "--junit": junit}
    watched: dict[str, object] = {"--console": console, "--rate": rate}
    if resume is not None:
        from waypointctl.cli.flight_view import resume_flight

        other = {"MISSION.yaml": missions, "--policy": policy, "--seed": seed, "--dry-run": dry_run}
        _refuse_beside("--resume: mission, policy, seed and file name are those of the log", other | flight)
        raise typer.Exit(resume_flight(resume, rate, plugin or (), console=console, json=json))
    plugins = tuple(plugin or ())
    if not missions:
        raise typer.BadParameter("name a mission file, or a log with --resume.", param_hint="MISSION.yaml")
    if dry_run:
        from waypointctl.cli.rehearsing import dry_run as fly_dry

        _refuse_beside("--dry-run", flight | watched)
        raise typer.Exit(fly_dry([_mission(path, seed, policy) for path in missions], policy, plugins, as_json=json))
    if len(missions) > 1 or junit is not None:
        from waypointctl.cli.run_many import run_many

        beside = "several missions" if len(missions) > 1 else "--junit"
        _refuse_beside(beside, watched | ({"--out": out} if len(missions) > 1 else {}))
        load = partial(_mission, seed=seed, policy=policy)
        raise typer.Exit(run_many(missions, load, policy, plugins, out, force=force, junit=junit, as_json=json))
    file = _mission(missions[0], seed, policy)
    raise typer.Exit(_fly(file, policy, plugins, out, rate, force=force, console=console, json=json))


def _fly(
    file: MissionFile,
    policy: Path | None,
    plugins: tuple[Path, ...],
    out: Path | None,
    rate: float | None,
    *,
    force: bool,
    console: bool,
    json: bool,
) -> int:
    """Fly one mission for a person who watches; return the exit code."""
    from waypointctl.cli.flight_view import flight_view, report_flight
    from waypointctl.cli.log_place import claimed
    from waypointctl.cli.program import interruption
    from waypointctl.flight.fly import fly
    from waypointctl.policy.bundle import load_policy

    loaded = load_policy(policy or file.policy_path)
    # Before the flight, a file may block for long, so a signal ends the program at once.
    with interruption() as interrupted, claimed(file.mission.name, out, force=force) as path:
        began_s = time.monotonic()
        with flight_view(file.mission, rate, interrupted, console=console) as view:
            result = fly(
                file,
                loaded,
                view.sink,
                log=path,
                pictures=True,
                console=view.console,
                plugins=plugins,
                interrupted=interrupted,
            )
        wall_s = time.monotonic() - began_s
    return report_flight(file.mission.name, result, view.watch.flight.summary(), wall_s, json=json)


def _refuse_beside(what: str, options: Mapping[str, object]) -> None:
    """Refuse the options that cannot be used with `what`."""
    for name, value in options.items():
        if not (value is None or value is False or value == []):
            raise typer.BadParameter(f"cannot be used with {what}.", param_hint=name)


def _mission(path: Path, seed: int | None, policy: Path | None) -> MissionFile:
    """Read a mission file; refuse one whose policy is not there, unless another one flies it."""
    from dataclasses import replace

    from waypointctl.mission.files import load_mission

    file = load_mission(path)
    if policy is None:
        _refuse_missing_policy(file)
    return file if seed is None else replace(file, mission=file.mission.model_copy(update={"seed": seed}))


def _refuse_missing_policy(mission_file: MissionFile) -> None:
    """Refuse a mission whose policy is not there, with the place where it is named."""
    from waypointctl.display_text import shell_word
    from waypointctl.errors import MissionError
    from waypointctl.mission.policy_name import policies_there_are
    from waypointctl.paths import folder_fault

    if fault := folder_fault(mission_file.policy_path):
        problem = f"policy: {mission_file.policy_path}: {fault}"
        named, beside = mission_file.mission.policy, mission_file.path.parent.resolve()
        hint = (
            f"The mission names {named!r}, relative to its own folder {beside}. {policies_there_are(named)} "
            f"`waypointctl run {shell_word(str(mission_file.path))} --policy POLICY` flies another one."
        )
        raise MissionError(problem, where=mission_file.place("policy"), hint=hint)
