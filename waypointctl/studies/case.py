"""The flights of a delay study, and the mission that each of them is."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from waypointctl.errors import InputError
from waypointctl.flight.link.build import contacts_of
from waypointctl.mission.fields import DAY_S
from waypointctl.mission.mission import Mission
from waypointctl.studies.route import with_round_trip
from waypointctl.units import seconds

# The finer sweep in which `joint` is followed to where it fails [s].
FINE_RTTS_S: Final = tuple(step * 20 / 1000 for step in range(14))

_MOST_SENDS: Final = 10  # of a command over a link that loses messages, which limits leave time for
_LONGEST_S: Final = 100 * DAY_S


@dataclass(frozen=True, slots=True)
class Autonomy:
    """A way of commanding, which a study compares with others.

    Attributes:
        name: as tables call it.
        level: the mission's `autonomy`.
        steering: the operator's, where the level is `short_range_goal`.
        waits: the operator sends nothing more until it knows how its last command ended.
    """

    name: str
    level: Literal["mission", "waypoint", "short_range_goal", "joint"]
    steering: Literal["move_and_wait", "continuous"] = "move_and_wait"
    waits: bool = True


MISSION: Final = Autonomy("mission", "mission")
WAYPOINT: Final = Autonomy("waypoint", "waypoint")
SHORT_RANGE_GOAL: Final = Autonomy("short_range_goal", "short_range_goal")
CONTINUOUS: Final = Autonomy("short_range_goal-continuous", "short_range_goal", "continuous", waits=False)
JOINT: Final = Autonomy("joint", "joint", waits=False)

AUTONOMIES: Final = {one.name: one for one in (MISSION, WAYPOINT, SHORT_RANGE_GOAL, CONTINUOUS, JOINT)}


def autonomies_of(names: Sequence[str]) -> list[str]:
    """Return names of autonomies in the order of AUTONOMIES, each once.

    Raises:
        InputError: there is none of a name.
    """
    if unknown := [name for name in names if name not in AUTONOMIES]:
        problem = f"--autonomy: {unknown[0]!r} is not an autonomy; choose from {', '.join(AUTONOMIES)}"
        raise InputError(problem, hint="Separate several by commas, as in --autonomy mission,waypoint.")
    return [name for name in AUTONOMIES if name in names]


@dataclass(frozen=True, slots=True, order=True)
class DelayCase:
    """One flight: nothing else decides how it goes but the policy, the route and the operator's think time.

    Attributes:
        route: its name.
        autonomy: its name.
        rtt_s: the link's round trip, half of it each way.
        seed: the mission's. Flights with one seed start in the same posture however they are commanded, so that what
            differs between two autonomies or two round trips is the delay.
    """

    route: str
    autonomy: str
    rtt_s: float
    seed: int


def grid(
    routes: Iterable[str], autonomies: Iterable[str], rtts_s: Sequence[float], seeds: Sequence[int]
) -> list[DelayCase]:
    """Return a case for each combination, the seeds innermost."""
    return [DelayCase(*key) for key in itertools.product(routes, autonomies, rtts_s, seeds)]


def fine_grid(routes: Iterable[str], seeds: Sequence[int]) -> list[DelayCase]:
    """Return the cases of the finer sweep, which find out where `joint` fails."""
    return grid(routes, [JOINT.name], FINE_RTTS_S, seeds)


def mission_of(route: Mission, case: DelayCase, think_s: float | None = None) -> Mission:
    """Return the mission of a case: the route with its delay, its autonomy, its seed and its time limits.

    Limits grow with the round trip, and with what the link loses and lets wait: they are there for a robot that has
    lost its way, not to end the study's longest flights. All else is the route's own.

    Args:
        route: that `refuse_what_is_not_kept` has let pass.
        case: of the study.
        think_s: in place of the route's own think time [s].
    """
    autonomy = AUTONOMIES[case.autonomy]
    think_s = route.operator.think_s if think_s is None else think_s
    allowance_s = _exchanges_of_a_leg(route) * (_exchange_s(route, case.rtt_s) + think_s)
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
            "link": with_round_trip(route.link, case.rtt_s),
            "waypoints": tuple(waypoints),
            "expect": route.expect.model_copy(update={"max_time_s": min(longest_s, _LONGEST_S)}),
        }
    )


def _exchanges_of_a_leg(route: Mission) -> int:
    """Return how often the operator may command during the longest leg: twice the number of its short-range goals."""
    places = [route.start.position_m, *((leg.x_m, leg.y_m) for leg in route.legs())]
    longest_m = max(math.dist(a, b) for a, b in itertools.pairwise(places))
    return 2 * math.ceil(longest_m / route.operator.lookahead_m) + 2


def _exchange_s(route: Mission, rtt_s: float) -> float:
    """Return how long a command and its answer may take over a route's link with another round trip [s]."""
    link, commands = route.link, route.commands
    sends = min(1 + commands.retries, _MOST_SENDS) if link.up.loss or link.down.loss else 1
    waits_s = 0.0
    for way in (link.up, link.down):
        contacts = contacts_of(way, route.files)
        waits_s += seconds(contacts.longest_gap_ns + (contacts.next_open_ns(0) or 0))
        if way.rate_bps is not None:
            waits_s += way.queue_bytes * 8 / way.rate_bps
    return sends * rtt_s + (sends - 1) * commands.margin_s + waits_s
