"""Telemetry that comes faster than the link down carries it: acknowledgements wait behind it, or find no room."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from waypointctl.flight.forecast.budget import Budget
from waypointctl.flight.forecast.duration import Expected
from waypointctl.flight.forecast.rehearsal import rehearse
from waypointctl.flight.forecast.traffic import Traffic, mean_rate_bps, telemetry_bps
from waypointctl.mission.mission import Mission

_FELT_S: Final = 0.1
_LITTLE: Final = 0.5  # of what the link carries: telemetry that nothing waits for long behind


@dataclass(frozen=True, slots=True)
class Queued:
    """What telemetry in the queue makes of a mission.

    Attributes:
        expected: with it.
        counted: whether it is in it.
        follows: what follows for the mission, in words; empty where nothing does.
    """

    expected: Expected
    counted: bool = True
    follows: str = ""


def queued(mission: Mission, speed_mps: float, traffic: Traffic, without: Expected, budget: Budget) -> Queued:
    """Return what is expected of a mission whose acknowledgements wait behind its telemetry.

    It is gone through on paper, once as it is and once with little telemetry; the difference is the wait.

    Args:
        mission: of which the schedule is not looked at.
        speed_mps: how fast the policy walks.
        traffic: its link.
        without: what is expected under an autonomy if nothing waits.
        budget: of what is rehearsed; where it is spent the wait is not counted.
    """
    needed_bps, has_bps = telemetry_bps(mission), mean_rate_bps(traffic.down.contacts)
    if has_bps is None or needed_bps <= has_bps or without.time_s is None:
        return Queued(without)
    if without.autonomy == "joint":
        return Queued(without, counted=False)
    expect = mission.expect.model_copy(update={"max_time_s": None})
    asked = mission.model_copy(update={"autonomy": without.autonomy, "expect": expect, "schedule": ()})
    rate_hz = mission.telemetry.rate_hz * _LITTLE * has_bps / needed_bps
    little = asked.model_copy(update={"telemetry": mission.telemetry.model_copy(update={"rate_hz": rate_hz})})
    plain, waits = (rehearse(each, speed_mps, without.time_s, budget) for each in (little, asked))
    if plain is None or waits is None or not plain.good:
        return Queued(without, counted=False)
    if not waits.good:
        why = f"the mission fails at about {waits.time_s:.1f} s: {waits.reason}"
        return Queued(replace(without, time_s=None), follows=why)
    added_s = max(waits.time_s - plain.time_s, 0.0)
    follows = f"the mission takes {added_s:.1f} s longer by it" if added_s >= _FELT_S else ""
    return Queued(replace(without, time_s=without.time_s + added_s), follows=follows)
