"""A flight of a study, and the mission that it is."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from waypointctl.mission.link import Link, Way
from waypointctl.mission.mission import DAY_S, Mission
from waypointctl.study.autonomy import AUTONOMIES

# The finer sweep in which `joint` is followed to where it fails [s].
FINE_RTTS_S: Final = tuple(step * 20 / 1000 for step in range(14))

_LONGEST_S: Final = 100 * DAY_S


@dataclass(frozen=True, slots=True, order=True)
class Case:
    """One flight: nothing else decides how it goes but the policy and the operator's think time.

    Attributes:
        route: its name.
        autonomy: its name.
        rtt_s: the link's round trip, half of it each way.
        seed: the mission's. It is the trial's number: a trial starts in the same posture however it is commanded, so
            that what differs between two autonomies or two round trips is the delay.
    """

    route: str
    autonomy: str
    rtt_s: float
    seed: int


def grid(routes: Iterable[str], autonomies: Iterable[str], rtts_s: Sequence[float], seeds: Sequence[int]) -> list[Case]:
    """Return a case for each combination, the seeds innermost."""
    return [Case(*key) for key in itertools.product(routes, autonomies, rtts_s, seeds)]


def mission_of(route: Mission, case: Case, think_s: float) -> Mission:
    """Return the mission of a case: the route with its delay, its autonomy, its seed and its time limits.

    Limits grow with the round trip: they are there for a robot that has lost its way, not to end the study's longest
    flights. A link's jitter, loss and windows are left out.
    """
    autonomy = AUTONOMIES[case.autonomy]
    way = Way(delay_s=case.rtt_s / 2)
    allowance_s = _exchanges_of_a_leg(route) * (case.rtt_s + think_s)
    limits_s = {leg.at: min(leg.timeout_s + allowance_s, DAY_S) for leg in route.legs()}
    waypoints = [
        waypoint.model_copy(update={"timeout_s": limits_s.get(at, waypoint.timeout_s)})
        for at, waypoint in enumerate(route.waypoints)
    ]
    longest_s = sum(limits_s[leg.at] + leg.hold_s for leg in route.legs()) + allowance_s
    return route.model_copy(
        update={
            "seed": case.seed,
            "autonomy": autonomy.level,
            "operator": route.operator.model_copy(update={"steering": autonomy.steering, "think_s": think_s}),
            "link": Link(up=way, down=way),
            "schedule": (),
            "waypoints": tuple(waypoints),
            "expect": route.expect.model_copy(update={"max_time_s": min(longest_s, _LONGEST_S)}),
        }
    )


def _exchanges_of_a_leg(route: Mission) -> int:
    """Return how often the operator may command during the longest leg: twice what its carrots take."""
    places = [route.start.position_m, *((leg.x_m, leg.y_m) for leg in route.legs())]
    longest_m = max(math.dist(a, b) for a, b in itertools.pairwise(places))
    return 2 * math.ceil(longest_m / route.operator.carrot_m) + 2
