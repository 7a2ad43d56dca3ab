"""A study that flies in no time: a policy that stands, and a route that is under its feet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.studies.case import DelayCase
from waypointctl.studies.flights import Cell, DelayFlight, cells_of

# Reached as soon as it is asked for: what a flight takes is what the link takes.
HERE = b"""\
name: here
policy: still
defaults: {tolerance: 3 m}
waypoints: [[0 m, 0 m], [0.5 m, 0 m], [0 m, 0.5 m]]
"""


def here(name: str = "here") -> MissionFile:
    source = HERE.replace(b"name: here", f"name: {name}".encode())
    return MissionFile(parse_mission(source, "here.yaml"), source, Path("here.yaml"))


def flight(case: DelayCase, time_s: float | None, exchanges: int = 1) -> DelayFlight:
    """Return a flight that took `time_s`, or failed."""
    return DelayFlight(
        route=case.route,
        autonomy=case.autonomy,
        rtt_s=case.rtt_s,
        seed=case.seed,
        outcome="failure" if time_s is None else "success",
        reason="fall" if time_s is None else "",
        time_s=1.0 if time_s is None else time_s,
        distance_m=20.0,
        standing_s=0.0 if time_s is None else time_s / 4,
        falls=int(time_s is None),
        exchanges=exchanges,
    )


def line(autonomy: str, times_s: Mapping[float, Sequence[float | None]], exchanges: int = 1) -> list[DelayFlight]:
    """Return flights of an autonomy: by round trip, the time of each trial."""
    return [
        flight(DelayCase("r", autonomy, rtt_s, seed), time_s, exchanges)
        for rtt_s, trials in times_s.items()
        for seed, time_s in enumerate(trials)
    ]


def cells(flown: Sequence[DelayFlight]) -> tuple[Cell, ...]:
    by_case = {one.case: one for one in flown}
    return cells_of(by_case, by_case)
