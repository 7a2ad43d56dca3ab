"""Rehearsals: a mission flown several times with several seeds, to predict its outcome."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias, get_args

from waypointctl.evaluation.result import wilson_interval
from waypointctl.flight.fly import fly
from waypointctl.flight.policy_fit import refuse_misfit
from waypointctl.log.messages import Event, EventKind
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.summary_builder import FlightSummaryBuilder
from waypointctl.robots.load import load_robot
from waypointctl.seeding import stream
from waypointctl.studies.engine import Interrupted, engine_for
from waypointctl.task.plugins import load_plugins
from waypointctl.units import seconds

AUTONOMIES: Final[tuple[str, ...]] = get_args(Mission.model_fields["autonomy"].annotation)

# Messages that did not arrive: (direction, kind of message, why).
Undelivered: TypeAlias = tuple[str, str, str]


@dataclass(frozen=True, slots=True)
class RehearsalCase:
    """One flight of a rehearsal."""

    mission: int  # its place among those that are rehearsed
    autonomy: str
    seed: int


@dataclass(frozen=True, slots=True)
class RehearsedFlight:
    """How a flight of a rehearsal ended."""

    seed: int  # of the mission, with which `run --seed` flies the same flight
    outcome: Literal["success", "failure"]  # as the operator knows it
    cause: str  # why it failed, without figures; empty for a success
    waypoint: str  # the one that the robot was on its way to at the end; empty for a success
    time_s: float  # until the operator knew the outcome
    waypoints_reached: int  # that the operator knew to be reached
    undelivered: Mapping[Undelivered, int]  # counts of messages that the link did not deliver


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """The flights of a mission under one autonomy."""

    autonomy: str
    flights: tuple[RehearsedFlight, ...]

    @property
    def successes(self) -> int:
        """How many flights were a success."""
        return sum(flight.outcome == "success" for flight in self.flights)

    @property
    def wilson95(self) -> tuple[float, float]:
        """The 95 % interval of the success rate."""
        return wilson_interval(self.successes, len(self.flights))

    @property
    def time_s(self) -> tuple[float, float, float] | None:
        """Median, shortest and longest time of the successes [s]; None without a success."""
        times_s = [flight.time_s for flight in self.flights if flight.outcome == "success"]
        return (statistics.median(times_s), min(times_s), max(times_s)) if times_s else None

    @property
    def failures(self) -> list[tuple[str, str, int, int]]:
        """Failures by cause and waypoint, the most frequent first: cause, waypoint, flights, seed of the first."""
        failed = [flight for flight in self.flights if flight.outcome == "failure"]
        counts = Counter((flight.cause, flight.waypoint) for flight in failed)
        first = {(flight.cause, flight.waypoint): flight.seed for flight in reversed(failed)}
        return [(*key, count, first[key]) for key, count in counts.most_common()]

    @property
    def undelivered(self) -> list[tuple[Undelivered, int, int]]:
        """Messages that were not delivered, the most frequent first: which, messages, flights."""
        messages: Counter[Undelivered] = Counter()
        for flight in self.flights:
            messages.update(flight.undelivered)
        return [
            (which, count, sum(which in flight.undelivered for flight in self.flights))
            for which, count in messages.most_common()
        ]

    def record(self) -> dict[str, Any]:
        """Return the rehearsal as plain data."""
        median_s, shortest_s, longest_s = self.time_s or (None, None, None)
        return {
            "autonomy": self.autonomy,
            "flights": len(self.flights),
            "successes": self.successes,
            "wilson95": self.wilson95,
            "time_s": {"median": None if median_s is None else round(median_s, 9), "min": shortest_s, "max": longest_s},
            "failures": [
                {"cause": cause, "waypoint": waypoint, "flights": flights, "first_seed": seed}
                for cause, waypoint, flights, seed in self.failures
            ],
            "undelivered": [
                {"direction": way, "message": what, "cause": why, "messages": messages, "flights": flights}
                for (way, what, why), messages, flights in self.undelivered
            ],
            "each": [
                {
                    "seed": flight.seed,
                    "outcome": flight.outcome,
                    "cause": flight.cause,
                    "waypoint": flight.waypoint,
                    "time_s": flight.time_s,
                    "waypoints_reached": flight.waypoints_reached,
                }
                for flight in self.flights
            ],
        }


def rehearsal_seed(mission: Mission, index: int) -> int:
    """Return the seed of a flight by its index: the mission's own for the first, drawn from it for the others."""
    return int(stream(mission.seed, "rehearsal", index).integers(2**63)) if index else mission.seed


def rehearse(
    missions: Sequence[tuple[Mission, LoadedPolicy]],
    autonomies: Callable[[Mission], Sequence[str]],
    flights: int,
    processes: int,
    progress: Callable[[int, int], None],
    interrupted: Interrupted,
    plugins: tuple[Path, ...] = (),
) -> list[list[Rehearsal]] | None:
    """Fly each mission several times under each autonomy; return its rehearsals, or None if it was interrupted.

    Args:
        missions: each with the policy that flies it.
        autonomies: of a mission.
        flights: of each mission and autonomy.
        processes: that fly; 0 for one a core.
        progress: called with the number of flights that have ended, and of all.
        interrupted: whether to stop.
        plugins: Python files with groups and terms of the policies; each process executes them.

    Raises:
        PolicyError: a policy was made for another robot or another observation layout.
        WaypointctlError: a worker process was killed.
    """
    executed = load_plugins(plugins)
    for mission, policy in missions:
        refuse_misfit(policy, load_robot(mission.robot), executed)
    groups = [(at, autonomy) for at, (mission, _) in enumerate(missions) for autonomy in autonomies(mission)]
    cases = [
        RehearsalCase(at, autonomy, rehearsal_seed(missions[at][0], index))
        for at, autonomy in groups
        for index in range(flights)
    ]
    ended = 0

    def count(case: RehearsalCase, flight: RehearsedFlight) -> None:
        nonlocal ended
        ended += 1
        progress(ended, len(cases))

    flown = engine_for(processes, len(cases)).map(_Fly(missions, plugins), cases, count, interrupted)
    if flown is None:
        return None
    found: list[list[Rehearsal]] = [[] for _ in missions]
    for place, (at, autonomy) in enumerate(groups):
        found[at].append(Rehearsal(autonomy, tuple(flown[place * flights : (place + 1) * flights])))
    return found


@dataclass(frozen=True, slots=True)
class _Fly:
    """Flies cases of rehearsals."""

    missions: Sequence[tuple[Mission, LoadedPolicy]]
    plugins: tuple[Path, ...]

    def __call__(self, case: RehearsalCase, interrupted: Interrupted) -> RehearsedFlight | None:
        mission, policy = self.missions[case.mission]
        mission = mission.model_copy(update={"autonomy": case.autonomy, "seed": case.seed})
        flight = FlightSummaryBuilder()
        result = fly(mission, policy, flight, plugins=self.plugins, interrupted=interrupted)
        if result.outcome == "interrupted":
            return None
        failed, summary = result.outcome != "success", flight.summary()
        ways = {"up": summary.link.up, "down": summary.link.down}
        return RehearsedFlight(
            seed=case.seed,
            outcome="failure" if failed else "success",
            cause=result.reason.partition(":")[0] if failed else "",
            waypoint=_on_the_way_to(mission, summary.events) if failed else "",
            time_s=seconds(result.known_ns),
            waypoints_reached=result.waypoints_reached,
            undelivered={
                (way, kind, outcome.value): count
                for way, link in ways.items()
                for (kind, outcome), count in link.undelivered.items()
            },
        )


def _on_the_way_to(mission: Mission, events: Sequence[Event]) -> str:
    """Return the waypoint that the robot was on its way to at the end; empty where all were reached."""
    last = next((event for event in reversed(events) if event.waypoint >= 0), None)
    leg = 0 if last is None else last.waypoint + (last.kind is EventKind.WAYPOINT_REACHED)
    return (*(each.name for each in mission.legs()), "")[leg]
