"""Flying a case of a delay study, and what is measured."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict

from waypointctl.evaluation.result import wilson_interval
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
    """Flies cases of a delay study."""

    routes: Mapping[str, MissionFile]  # by name
    policy: LoadedPolicy  # that drives the robot
    think_s: float | None = None  # the operator's, in place of the routes' own
    logs: Path | None = None  # the folder for the flights' logs, which is there; None for none
    plugins: tuple[Path, ...] = ()  # Python files, which are executed

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


_CONFIDENCE: Final = 0.95
_NODES: Final = 64  # of the quadrature: exact to ten digits and more


class Estimate(BaseModel):
    """A value and the half width of its interval; None where a single flight gives no interval."""

    model_config = ConfigDict(frozen=True)

    value: float
    half: float | None  # of the 95 % interval

    def __str__(self) -> str:
        """Return it with as many digits as a table needs."""
        return f"{self.value:.2f}" if self.half is None else f"{self.value:.2f} ± {self.half:.2f}"


def mean(values: Sequence[float]) -> Estimate:
    """Return the mean of values, of which there is at least one."""
    if len(values) == 1:
        return Estimate(value=values[0], half=None)
    error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return Estimate(value=float(np.mean(values)), half=student(len(values) - 1) * error)


def slope(x: Sequence[float], y: Sequence[float]) -> Estimate:
    """Return the slope of the line of least squares through points (x, y).

    Raises:
        ValueError: all points have one x.
    """
    across, along = np.array(x) - np.mean(x), np.array(y) - np.mean(y)
    spread = float(across @ across)
    if not spread:
        raise ValueError("a slope needs two different x")
    value = float(across @ along) / spread
    freedom = len(x) - 2
    if not freedom:
        return Estimate(value=value, half=None)
    rest = along - value * across
    return Estimate(value=value, half=student(freedom) * math.sqrt(float(rest @ rest) / freedom / spread))


@cache
def student(freedom: int) -> float:
    """Return how many standard errors the 95 % interval reaches to either side, by its degrees of freedom."""
    low, high = 0.0, 20.0
    while high - low > 1e-9:
        middle = (low + high) / 2
        low, high = (middle, high) if _central(middle, freedom) < _CONFIDENCE else (low, middle)
    return (low + high) / 2


def _central(t: float, freedom: int) -> float:
    """Return how probable it is that Student's t lies within ±`t`.

    With t = sqrt(freedom) tan(angle) its density is a constant times cos(angle)**(freedom - 1), which is smooth.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    end = math.atan(t / math.sqrt(freedom))
    angles = end * (nodes + 1) / 2
    area = float(weights @ np.cos(angles) ** (freedom - 1)) * end / 2
    scale = math.exp(math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)) / math.sqrt(math.pi)
    return 2 * scale * area


class Cell(BaseModel):
    """The flights of a route, an autonomy and a round trip.

    Times and distances are those of the successes; None where there is none.
    """

    model_config = ConfigDict(frozen=True)

    route: str
    autonomy: str
    rtt_s: float
    flights: int
    successes: int
    rate: float
    wilson95: tuple[float, float]
    falls: int  # of all flights
    time_s: Estimate | None
    distance_m: Estimate | None
    standing_s: Estimate | None
    standing_share: Estimate | None  # of the time
    exchanges: float | None  # commands that the operator waited for, mean of a flight

    @property
    def mostly_succeeds(self) -> bool:
        """Whether at least half of the flights succeeded."""
        return 2 * self.successes >= self.flights


def cells_of(cases: Iterable[DelayCase], flown: Mapping[DelayCase, DelayFlight]) -> tuple[Cell, ...]:
    """Return a cell for each route, autonomy and round trip of `cases`, in their order, of those that were flown."""
    groups: dict[tuple[str, str, float], list[DelayFlight]] = {}
    for case in cases:
        if case in flown:
            groups.setdefault((case.route, case.autonomy, case.rtt_s), []).append(flown[case])
    return tuple(_cell(group) for group in groups.values())


def _cell(group: list[DelayFlight]) -> Cell:
    first, won = group[0], [one for one in group if one.succeeded]

    def of_successes(value: Callable[[DelayFlight], float]) -> Estimate | None:
        return mean([value(one) for one in won]) if won else None

    return Cell(
        route=first.route,
        autonomy=first.autonomy,
        rtt_s=first.rtt_s,
        flights=len(group),
        successes=len(won),
        rate=len(won) / len(group),
        wilson95=wilson_interval(len(won), len(group)),
        falls=sum(one.falls for one in group),
        time_s=of_successes(lambda one: one.time_s),
        distance_m=of_successes(lambda one: one.distance_m),
        standing_s=of_successes(lambda one: one.standing_s),
        standing_share=of_successes(lambda one: one.standing_s / one.time_s),
        exchanges=float(np.mean([one.exchanges for one in won])) if won else None,
    )
