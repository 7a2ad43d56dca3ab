"""`waypointctl run`: fly a mission, watch it, log it."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from waypointctl.cli.options import positive

if TYPE_CHECKING:
    from waypointctl.mission.files import MissionFile
    from waypointctl.ops.record import Recording

_EXIT_CODES: Final = {"success": 0, "failure": 1, "interrupted": 130}


def run(
    mission: Annotated[Path, typer.Argument(metavar="MISSION.yaml", help="The mission file.", show_default=False)],
    policy: Annotated[
        Path | None, typer.Option(help="Fly this policy's folder, not the mission's.", show_default=False)
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, max=2**63 - 1, help="Use this seed, not the mission's.", show_default=False)
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="The log.", show_default="logs/<mission>.mcap, or -2, -3, ...")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the file that --out names.")] = False,
    rate: Annotated[
        float | None,
        typer.Option(
            callback=positive, help="Simulated seconds in a second; as fast as it goes without it.", show_default=False
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
) -> None:
    """Fly a mission and log it. Exit with 0 for success, 1 for failure, 130 if it was interrupted."""
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.log_place import claimed
    from waypointctl.cli.view.pace import Pace, paced
    from waypointctl.cli.view.summary import print_flight
    from waypointctl.cli.view.watch import watch
    from waypointctl.ops.ground.operator import planned_waypoints
    from waypointctl.ops.record import record
    from waypointctl.policy.bundle import load_policy

    mission_file = _mission(mission, seed)
    plan = planned_waypoints(mission_file.mission)
    if policy is None:
        _refuse_missing_policy(mission_file)
    loaded = load_policy(policy or mission_file.policy_path)
    # Only a flight can be asked to end: before it, where a file may keep one waiting, a signal ends the program.
    with interruption() as interrupted, claimed(mission_file.mission.name, out, force=force) as path:
        began_s = time.monotonic()
        with watch(mission_file.mission.name, plan) as view:
            if rate is not None:
                view.say(f"at {rate:g} times real time")
            sink = view if rate is None else paced(view, Pace(rate), interrupted)
            recording = record(mission_file, loaded, path, watch=sink, interrupted=interrupted)
        wall_s = time.monotonic() - began_s
    print_flight(view.chronicle.story(), recording, wall_s, stderr=json)
    if json:
        sys.stdout.write(_json(mission_file, recording))
    raise typer.Exit(_EXIT_CODES[recording.result.outcome])


def _mission(path: Path, seed: int | None) -> MissionFile:
    from dataclasses import replace

    from waypointctl.mission.files import load_mission

    given = load_mission(path)
    return given if seed is None else replace(given, mission=given.mission.model_copy(update={"seed": seed}))


def _refuse_missing_policy(mission_file: MissionFile) -> None:
    """Refuse a mission whose policy is not there, with the place where it is named."""
    from waypointctl.errors import MissionError
    from waypointctl.paths import folder_fault

    if fault := folder_fault(mission_file.policy_path):
        problem = f"policy: {mission_file.policy_path}: {fault}"
        mend = "A policy is a folder with manifest.json, named relative to the mission's file; --policy flies another."
        raise MissionError(problem, where=mission_file.policy_place, mend=mend)


def _json(mission_file: MissionFile, recording: Recording) -> str:
    import json

    from waypointctl.units import seconds

    result = recording.result
    found = {
        "mission": mission_file.mission.name,
        "outcome": result.outcome,
        "reason": result.reason,
        "waypoints_reached": result.waypoints_reached,
        "waypoints_total": result.waypoints_total,
        "sim_time_s": seconds(result.sim_time_ns),
        "seed": recording.seed,
        "log": str(recording.path),
        "log_sha256": recording.sha256,
    }
    return f"{json.dumps(found, indent=2)}\n"
