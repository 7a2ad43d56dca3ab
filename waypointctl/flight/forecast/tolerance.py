"""Tolerances that a policy walking at its speed may never meet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.forecast.finding import NOT_COMPLETED, Finding
from waypointctl.mission.mission import Mission

# The evaluations go down to 0.2 m (README.md, "region, within 0.2 m": 983 of 1,000). Beyond them, six flights of the
# shipped policy over two waypoints each: within 0.1 m and 0.05 m all reached in the same time; within 0.02 m it walks
# round them, 1.6 times as long, within 0.01 m 2.3 times; within 0.001 m none of twelve is reached.
SMALLEST_M: Final = 0.05
NEAREST_M: Final = 0.0011  # the robot comes no nearer to a place than this


def is_missed(mission: Mission, tolerance_m: float) -> bool:
    """Tell whether a waypoint is never reached for its tolerance."""
    return tolerance_m < NEAREST_M and mission.onboard.slip_m < SMALLEST_M


def tolerance_findings(mission: Mission) -> Iterator[Finding]:
    """Yield the tolerances that are smaller than any a policy was evaluated with, by far."""
    if mission.onboard.slip_m >= SMALLEST_M:
        return  # a near miss counts
    seen = set()
    for leg in mission.legs():
        if leg.tolerance_m < SMALLEST_M and leg.at not in seen:
            seen.add(leg.at)
            consequence = NOT_COMPLETED if is_missed(mission, leg.tolerance_m) else None
            yield _too_small(("waypoints", leg.at, "tolerance_m"), leg.name, leg.tolerance_m, consequence)
    for place, command in enumerate(mission.schedule):
        if command.tolerance_m is not None and command.tolerance_m < SMALLEST_M:
            yield _too_small(("schedule", place, "tolerance_m"), command.do, command.tolerance_m)


def _too_small(path: tuple[str | int, ...], what: str, tolerance_m: float, consequence: str | None = None) -> Finding:
    text = (
        f"{what}: {tolerance_m:g} m is finer than a robot walks: it goes round the place, maybe until its time is out; "
        f"give it {SMALLEST_M:g} m or more, or let onboard.slip make a near miss count"
    )
    return Finding("tolerance", path, text, consequence)
