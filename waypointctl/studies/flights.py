"""Flying a case of a delay study, and what is measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict

from waypointctl.flight.fly import fly
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import EventKind
from waypointctl.mission.files import MissionFile
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.summary_builder import FlightSummaryBuilder
from waypointctl.studies.case import AUTONOMIES, DelayCase, mission_of
from waypointctl.studies.engine import Interrupted
from waypointctl.units import seconds

STILL_MPS: Final = 0.05  # a robot slower than this stands


class DelayFlight(BaseModel):
    """A case and how it went."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    route: str
    autonomy: str
    rtt_s: float
    seed: int
    outcome: Literal["success", "failure"]  # as the operator knows it
    reason: str
    time_s: float  # on the operator's clock, from mission start until it knows the outcome
    distance_m: float  # driven by the robot
    standing_s: float  # in which it was slower than STILL_MPS
    falls: int
    exchanges: int  # commands whose end the operator waited for before it continued

    @property
    def case(self) -> DelayCase:
        """What was flown."""
        return DelayCase(self.route, self.autonomy, self.rtt_s, self.seed)

    @property
    def succeeded(self) -> bool:
        """Whether the mission was a success."""
        return self.outcome == "success"


@dataclass(frozen=True, slots=True)
class FlyCase:
    """Flies cases of a delay study.

    Attributes:
        routes: by name.
        policy: that drives the robot.
        think_s: the operator's, in place of the routes' own.
        logs: the folder for the flights' logs, which is there; None for none.
        plugins: Python files, which are executed.
    """

    routes: Mapping[str, MissionFile]
    policy: LoadedPolicy
    think_s: float | None = None
    logs: Path | None = None
    plugins: tuple[Path, ...] = ()

    def __call__(self, case: DelayCase, interrupted: Interrupted) -> DelayFlight | None:
        """Fly a case; return how it went, None if it was interrupted."""
        file, flight = self.routes[case.route], FlightSummaryBuilder()
        mission = mission_of(file.mission, case, self.think_s)
        log = None if self.logs is None else self.logs / log_name(case)
        result = fly(mission, self.policy, flight, log=log, plugins=self.plugins, interrupted=interrupted)
        return None if result.outcome == "interrupted" else measured(case, result, flight.summary())


def log_name(case: DelayCase) -> str:
    """Return the name of the log of a case."""
    return f"{case.route}-{case.autonomy}-{case.rtt_s:g}s-{case.seed}.mcap"


def measured(case: DelayCase, result: FlightResult, summary: FlightSummary) -> DelayFlight:
    """Return what a study keeps of a flight: distance and standing are the robot's true ones."""
    time_s, truth = seconds(result.known_ns), summary.truth
    # By time, not by number: a robot at rest has no states until something happens to it.
    standing_ns = int(np.diff(truth.time_ns)[truth.speed_mps[:-1] < STILL_MPS].sum())
    known = sum(command.end_known_ns is not None for command in summary.commands)
    return DelayFlight(
        route=case.route,
        autonomy=case.autonomy,
        rtt_s=case.rtt_s,
        seed=case.seed,
        outcome="success" if result.outcome == "success" else "failure",
        reason=result.reason,
        time_s=time_s,
        distance_m=round(summary.effort.distance_m, 6),
        standing_s=min(seconds(standing_ns), time_s),  # the robot moves on to the end of its control period
        falls=sum(event.kind is EventKind.FALL for event in summary.events),
        exchanges=known if AUTONOMIES[case.autonomy].waits else 0,
    )
