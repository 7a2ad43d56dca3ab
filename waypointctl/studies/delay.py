"""The delay study: round trips by autonomies by routes, flown into a folder, and what was found."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict, ValidationError

from waypointctl.errors import InputError
from waypointctl.flight.header import source_revision
from waypointctl.flight.policy_fit import refuse_misfit
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.mission.files import MissionFile
from waypointctl.paths import write_whole
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.robots.load import load_robot
from waypointctl.studies.case import MISSION, DelayCase, refuse_what_is_not_kept
from waypointctl.studies.claims import ClaimResult, JointLimit, assess_claims, joint_limits
from waypointctl.studies.engine import Interrupted, engine_for
from waypointctl.studies.flights import Cell, DelayFlight, FlyCase, cells_of
from waypointctl.studies.results_file import ResultsFile, StudyInputs
from waypointctl.task.plugins import load_plugins

LOGS: Final = "logs"
STUDY: Final = "study.json"
TABLES: Final = "tables.md"
VALUES: Final = "cells.csv"
PICTURE: Final = "delay.png"


class Route(BaseModel):
    """A route as a table shows it."""

    model_config = ConfigDict(frozen=True)

    name: str
    waypoints: int
    length_m: float  # of the straight path
    think_s: float = 0.0  # how long the operator thinks on it

    @property
    def what(self) -> str:
        """Its number of waypoints, in words."""
        return f"{self.waypoints} waypoint{'s' * (self.waypoints != 1)}"


class DelayStudy(BaseModel):
    """What a delay study found; all that its tables and its picture show."""

    model_config = ConfigDict(frozen=True)

    policy: str
    policy_sha256: str
    source: str  # a hash of the code that flew
    think_s: float | None  # in place of the routes' own
    seeds: tuple[int, ...]
    routes: tuple[Route, ...]
    cells: tuple[Cell, ...]
    joint_sweep: tuple[Cell, ...]  # `joint` at the finer round trips, where it was asked for
    joint_limits: tuple[JointLimit, ...]
    claims: tuple[ClaimResult, ...]

    def cells_of(self, route: str, autonomy: str) -> tuple[Cell, ...]:
        """Return the cells of a line of the picture, by round trip; those of the finer sweep among them."""
        own = {
            cell.rtt_s: cell
            for cell in (*self.joint_sweep, *self.cells)
            if (cell.route, cell.autonomy) == (route, autonomy)
        }
        return tuple(own[rtt_s] for rtt_s in sorted(own))

    def undelayed_s(self, route: str) -> float | None:
        """Return how long a route takes without any delay, L/v [s]; None where that was not flown."""
        found = (cell.time_s for cell in self.cells_of(route, MISSION.name) if cell.rtt_s == 0)
        return next((time_s.value for time_s in found if time_s is not None), None)

    def predicted_s(self, route: str, autonomy: str, rtt_s: float) -> float | None:
        """Return T = L/v + N (RTT + think) [s] (W. R. Ferrell 1965), N as it was counted; None where there is none."""
        counts = [cell.exchanges for cell in self.cells_of(route, autonomy) if cell.exchanges]
        undelayed_s = self.undelayed_s(route)
        if undelayed_s is None or not counts:
            return None
        think_s = next(one.think_s for one in self.routes if one.name == route)
        return undelayed_s + sum(counts) / len(counts) * (rtt_s + think_s)


def study_delay(
    policy: LoadedPolicy,
    routes: Mapping[str, MissionFile],
    cases: Sequence[DelayCase],
    fine: Sequence[DelayCase],
    folder: Path,
    *,
    think_s: float | None = None,
    processes: int = 1,
    keep_logs: bool = False,
    plugins: tuple[Path, ...] = (),
    progress: Callable[[int, int], None] = lambda flown, total: None,
    interrupted: Interrupted = lambda: False,
) -> DelayStudy | None:
    """Fly the cases that `folder` does not have yet, and write what all of them came to; None if interrupted.

    Args:
        policy: that drives the robot.
        routes: by name.
        cases: of the study.
        fine: of the finer sweep of `joint`.
        folder: for the flights and what they came to; what is there already is not flown again.
        think_s: how long the operator thinks before it sends [s]; each route's own time if it is left out.
        processes: that fly; 0 for one a core. The results do not depend on it.
        keep_logs: write the logs of the flights, too.
        plugins: Python files with groups and terms of the policy; each process executes them.
        progress: called with the number of flights that have ended, those of an earlier run among them, and of all.
        interrupted: whether to stop.

    Raises:
        InputError: the policy does not fit; a route has what a study cannot keep; the folder has another study.
        OutputError: something cannot be written, or another study is writing there.
        WaypointctlError: a worker process was killed.
    """
    executed = load_plugins(plugins)
    for name in {file.mission.robot for file in routes.values()}:
        refuse_misfit(policy, load_robot(name), executed)
    refuse_what_is_not_kept(routes, sorted({case.rtt_s for case in cases}))
    inputs = inputs_of(policy, routes, think_s)
    with ResultsFile.held(folder, inputs) as results:
        logs = folder / LOGS if keep_logs else None
        if logs is not None:
            logs.mkdir(exist_ok=True)
        every = list(dict.fromkeys((*cases, *fine)))
        to_fly = [case for case in every if case not in results.flown]
        ended = itertools.count(len(every) - len(to_fly))
        progress(next(ended), len(every))

        def keep(case: DelayCase, flight: DelayFlight) -> None:
            results.add(flight)
            progress(next(ended), len(every))

        fly_case = FlyCase(routes, policy, think_s, logs, plugins)
        flown = engine_for(processes, len(to_fly)).map(fly_case, to_fly, keep, interrupted)
        results.write_in_order(every)
        if flown is None:
            return None
        study = conclude(cases, fine, results.flown, routes, inputs)
        write_study(study, folder)
    return study


def inputs_of(policy: LoadedPolicy, routes: Mapping[str, MissionFile], think_s: float | None) -> StudyInputs:
    """Return what decides how the cases of a study go."""
    digests = {name: route_digest(file) for name, file in routes.items()}
    return StudyInputs(
        policy=policy.manifest.name,
        policy_sha256=policy.sha256,
        think_s=think_s,
        source=source_revision(),
        routes=digests,
    )


def conclude(
    cases: Sequence[DelayCase],
    fine: Sequence[DelayCase],
    flown: Mapping[DelayCase, DelayFlight],
    routes: Mapping[str, MissionFile],
    inputs: StudyInputs,
) -> DelayStudy:
    """Return what the flights of `cases` and of the finer sweep found; `flown` has at least those."""
    cells, sweep = cells_of(cases, flown), cells_of(fine, flown)
    every = (*cells, *(cell for cell in sweep if cell not in cells))
    return DelayStudy(
        policy=inputs.policy,
        policy_sha256=inputs.policy_sha256,
        source=inputs.source,
        think_s=inputs.think_s,
        seeds=tuple(sorted({case.seed for case in cases})),
        routes=tuple(
            Route(
                name=name,
                waypoints=file.mission.num_legs,
                length_m=file.mission.path_length_m(),
                think_s=file.mission.operator.think_s if inputs.think_s is None else inputs.think_s,
            )
            for name, file in routes.items()
        ),
        cells=cells,
        joint_sweep=sweep,
        joint_limits=joint_limits(every),
        claims=assess_claims(every, [flown[case] for case in cases if case in flown]),
    )


def write_study(study: DelayStudy, folder: Path) -> None:
    """Write what a study found into its folder: as JSON, as tables, as comma-separated values and as a picture.

    Raises:
        OutputError: a file cannot be written.
    """
    from waypointctl.evaluation.grid import markdown_file
    from waypointctl.studies.picture import draw
    from waypointctl.studies.tables import MARKDOWN_HEAD, tables, to_csv

    write_whole(folder / STUDY, f"{study.model_dump_json(indent=2)}\n".encode(), "the study")
    write_whole(folder / TABLES, markdown_file(MARKDOWN_HEAD, tables(study)).encode(), "the tables")
    write_whole(folder / VALUES, to_csv(study).encode(), "the values")
    write_whole(folder / PICTURE, draw(study), "the picture")


def read_study(path: Path) -> DelayStudy:
    """Read what a study found.

    Raises:
        InputError: the file cannot be read or is not a delay study.
    """
    hint = "write it again with `waypointctl study delay`"
    content = read_input(path, RECORD_FILE, hint=hint)
    try:
        return DelayStudy.model_validate_json(content)
    except ValidationError as error:
        problem = f"not a delay study: {error.errors(include_url=False)[0]['msg']}"
        raise InputError(problem, where=str(path), hint=hint) from error


def route_digest(file: MissionFile) -> str:
    """Return the SHA-256 of a mission's file and of what stands in the files that it refers to."""
    digest = hashlib.sha256(file.source)
    for name, content in sorted(file.mission.files.items()):
        digest.update(name.encode() + b"\0" + hashlib.sha256(content).digest())
    return digest.hexdigest()
