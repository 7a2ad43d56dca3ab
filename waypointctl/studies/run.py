"""Flying a delay study into its folder, and going on with it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from waypointctl.flight.header import source_revision
from waypointctl.flight.record import refuse_misfit
from waypointctl.mission.files import MissionFile
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.robots.load import load_robot
from waypointctl.studies.case import Case
from waypointctl.studies.delay import DelayStudy, conclude
from waypointctl.studies.files import write_study
from waypointctl.studies.pilot import Plan, fly_cases
from waypointctl.studies.results_file import Conditions, ResultsFile
from waypointctl.studies.varied_link import refuse_what_is_not_kept

LOGS: Final = "logs"


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a study is.

    Attributes:
        flown: flights that have ended, those of an earlier run among them.
        total: flights of the study.
        last: the one that has just ended; None at the beginning.
    """

    flown: int
    total: int
    last: Case | None


def study_delay(
    policy: LoadedPolicy,
    routes: Mapping[str, MissionFile],
    cases: Sequence[Case],
    fine: Sequence[Case],
    folder: Path,
    *,
    think_s: float | None = None,
    jobs: int = 1,
    keep_logs: bool = False,
    watch: Callable[[Progress], None] = lambda progress: None,
    interrupted: Callable[[], bool] = lambda: False,
) -> DelayStudy | None:
    """Fly the cases that `folder` does not have yet, and write what all of them came to.

    Args:
        policy: who walks.
        routes: by name.
        cases: of the study.
        fine: of the finer sweep of `joint`.
        folder: for the flights and what they came to; what is there already is not flown again.
        think_s: how long the operator thinks before it sends [s]; each route's own time if it is left out.
        jobs: flights at a time. The results do not depend on it.
        keep_logs: write the logs of the flights, too.
        watch: told of each flight.
        interrupted: asked again and again; True ends it.

    Returns:
        What was found; None if it was interrupted.

    Raises:
        PolicyError: the policy was made for another robot or another observation layout.
        InputError: a route has what a study cannot keep; the folder has the flights of another study.
        OutputError: something cannot be written, or another study is at it.
        WaypointctlError: a process that flew was killed.
    """
    refuse_policy(policy, routes)
    refuse_what_is_not_kept(routes, sorted({case.rtt_s for case in cases if case.route in routes}))
    conditions = Conditions(
        policy=policy.manifest.name,
        policy_sha256=policy.sha256,
        think_s=think_s,
        source=source_revision(),
        routes={name: route_digest(file) for name, file in routes.items()},
    )
    with ResultsFile.held(folder, conditions) as results:
        logs = folder / LOGS if keep_logs else None
        if logs is not None:
            logs.mkdir(exist_ok=True)
        every = list(dict.fromkeys((*cases, *fine)))
        to_fly = [case for case in every if case not in results.flown]
        ended = len(every) - len(to_fly)
        watch(Progress(ended, len(every), None))
        plan = Plan(routes, policy.files, policy.manifest.name, think_s, logs)
        for flown in fly_cases(plan, to_fly, jobs, interrupted):
            results.add(flown)
            ended += 1
            watch(Progress(ended, len(every), flown.case))
        results.write_in_order(every)
        if ended < len(every):
            return None
        study = conclude(cases, fine, results.flown, routes, conditions)
        write_study(study, folder)
    return study


def route_digest(file: MissionFile) -> str:
    """Return the SHA-256 of a mission's file and of what stands in the files that it refers to."""
    digest = hashlib.sha256(file.source)
    for name, content in sorted(file.mission.files.items()):
        digest.update(name.encode() + b"\0" + hashlib.sha256(content).digest())
    return digest.hexdigest()


def refuse_policy(policy: LoadedPolicy, routes: Mapping[str, MissionFile]) -> None:
    """Refuse a policy that was not made for the routes' robots.

    Raises:
        PolicyError: it was made for another robot, observation layout, control period or kind of action.
    """
    for name in {file.mission.robot for file in routes.values()}:
        refuse_misfit(policy, load_robot(name))
