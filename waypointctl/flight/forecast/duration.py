"""How long a mission takes under each autonomy: T = L / v + N (RTT + think), with each exchange at its own time.

L is the way from where one waypoint counts as reached to where the next one does, and v the policy's mean speed; N is
how often the operator has to hear before it can say what is next. A round trip is what the link makes of it when its
time comes, with its windows and rates, without jitter and loss. What a schedule of commands adds is not in it, nor that
an operator who steers gives a leg up when its time is out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final, Literal, TypeAlias

from waypointctl.flight.forecast.goals import SETTING_OUT_S, goals_of, period_s, setting_out_s, whole
from waypointctl.flight.forecast.joint import falls
from waypointctl.flight.forecast.release import waits_for_ever
from waypointctl.flight.forecast.traffic import ACK_BYTES, Traffic, go_to_bytes, upload_bytes
from waypointctl.flight.forecast.way import Walk, stands_s, walks_of
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.mission.mission import Mission
from waypointctl.units import ns, seconds

Autonomy: TypeAlias = Literal["mission", "waypoint", "heading", "joint"]
AUTONOMIES: Final[tuple[Autonomy, ...]] = ("mission", "waypoint", "heading", "joint")

_LAST_GOAL_S: Final = 1.0  # steered at a rate, the last goal of all is over so soon, and need not wait for another
_MOST_CARROTS: Final = 20_000  # that are worked out one by one; more take as much longer as they are more


@dataclass(frozen=True, slots=True)
class Blocked:
    """A message that everything after it waits for, and that never arrives.

    Attributes:
        way: "up" for a command, "down" for its acknowledgement.
        ready_s: when it is handed to the link.
        size_bytes: its size.
    """

    way: Literal["up", "down"]
    ready_s: float
    size_bytes: int


@dataclass(frozen=True, slots=True)
class Expected:
    """How long a mission is expected to take.

    Attributes:
        autonomy: who decides what.
        time_s: from the first command to the operator's knowing of the end, or to the end of the flight where a way
            home, a hold or a rule on board goes on after that; None for never.
        exchanges: how often the operator has to hear before it can say what is next.
        blocked: the message that never gets through, where that is why the time is None.
        falls: whether the robot is expected to fall, which is why the time is None.
        fails: why it is expected to fail, in a few words; empty where it is not, or the other attributes say so.
    """

    autonomy: Autonomy
    time_s: float | None
    exchanges: int
    blocked: Blocked | None = None
    falls: bool = False
    fails: str = ""

    @property
    def succeeds(self) -> bool:
        """Whether the mission is expected to come to what it has to."""
        return self.time_s is not None and not self.fails


def expected(mission: Mission, speed_mps: float, traffic: Traffic, autonomy: Autonomy) -> Expected:
    """Return how long a mission takes under an autonomy, its own or another."""
    walks = walks_of(mission, speed_mps)
    retry = 1 + mission.failure_rule.retry
    spent_s = [
        seconds(walk.waypoint.timeout_ns) * retry if walk.duration_s is None else walk.duration_s for walk in walks
    ]
    first_s = SETTING_OUT_S if walks[0].duration_s is not None else 0.0  # the speed is that of a robot under way
    if autonomy == "mission" and waits_for_ever(mission):
        return Expected(autonomy, None, 1)
    if autonomy == "mission":
        return _at_once(autonomy, first_s + sum(spent_s), upload_bytes(mission), traffic)
    if autonomy == "joint" and falls(mission, traffic):
        return Expected(autonomy, None, 1, falls=True)
    if autonomy == "joint":
        return _at_once(autonomy, first_s + sum(spent_s), 1, traffic)
    steered = autonomy == "heading"
    if steered and mission.operator.steering == "continuous":
        return _continuous(mission, walks, spent_s, speed_mps, traffic)
    if steered:
        counts, heard = steered_moves(mission, walks, spent_s, traffic)
    else:
        counts = [1] * len(walks)
        spent_s[0] += first_s
        heard = [*_in_turn(_moves(walks, spent_s, counts), traffic, ns(mission.operator.think_s))]
    count = sum(counts)
    last = heard[-1]
    if isinstance(last, Blocked):
        return Expected(autonomy, None, count, last)
    return Expected(autonomy, seconds(last) * max(count / _MOST_CARROTS, 1.0), count)


def _at_once(autonomy: Autonomy, walking_s: float, size: int, traffic: Traffic) -> Expected:
    (heard,) = _in_turn([(walking_s, size)], traffic, 0)
    return Expected(autonomy, None, 1, heard) if isinstance(heard, Blocked) else Expected(autonomy, seconds(heard), 1)


def _moves(walks: Sequence[Walk], spent_s: Sequence[float], counts: Sequence[int]) -> Iterator[tuple[float, int]]:
    """Yield the moves of some legs, each of them made of several: (duration [s], command [bytes])."""
    for walk, spent, count in zip(walks, spent_s, counts, strict=True):
        size = go_to_bytes(walk.waypoint)
        yield from ((spent / count, size) for _ in range(count))


def _in_turn(moves: Iterable[tuple[float, int]], traffic: Traffic, think_ns: int) -> Iterator[int | Blocked]:
    """Yield when the operator hears of the end of each of some moves [ns]; what never gets through is the last."""
    now_ns = 0
    for place, (move_s, size) in enumerate(moves):
        ready_ns = now_ns + think_ns * (place > 0)
        arrives_ns = traffic.arrives_up_ns(ready_ns, size)
        if arrives_ns is None:
            yield Blocked("up", seconds(ready_ns), size)
            return
        heard_ns = traffic.heard_ns(arrives_ns + ns(move_s))
        if heard_ns is None:
            yield Blocked("down", seconds(arrives_ns + ns(move_s)), ACK_BYTES)
            return
        now_ns = heard_ns
        yield now_ns


def steered_moves(
    mission: Mission, walks: Sequence[Walk], spent_s: Sequence[float], traffic: Traffic
) -> tuple[list[int], list[int | Blocked]]:
    """Return of how many short moves each leg is made, and when the operator hears of each, as far as is worked out."""
    counts = whole([goals_of(walk, mission) for walk in walks])
    trip_s, think_s = round_trip_s(mission, traffic), mission.operator.think_s
    more_s = setting_out_s(think_s if isinstance(trip_s, Blocked) else trip_s + think_s)
    moves = ((move_s + more_s, size) for move_s, size in _moves(walks, spent_s, counts))
    return counts, [*_in_turn(islice(moves, _MOST_CARROTS), traffic, ns(think_s))]


def round_trip_s(mission: Mission, traffic: Traffic) -> float | Blocked:
    """Return how long after a goal, at mission start, its answer is heard [s]."""
    (heard,) = _in_turn([(0.0, go_to_bytes(planned_waypoints(mission)[0]))], traffic, 0)
    return heard if isinstance(heard, Blocked) else seconds(heard)


def steered_s(walk: Walk, mission: Mission, speed_mps: float, round_trip_s: float) -> float:
    """Return how long a way takes that is steered at a rate over a round trip [s], thoughts included.

    A goal ahead of an old pose bounds the speed: until the next one from a nearer pose has come, the robot comes to
    where the goal counts as reached, and not much further. Where it walks about as fast as the goals come, now the one
    is short and now the other: neither bound is reached.
    """
    cycles = goals_of(walk, mission, at_rate=True)
    script = mission.operator
    waits_s = cycles * period_s(round_trip_s + script.think_s, script.update_rate_hz)
    return float(math.cbrt((walk.way_m / speed_mps) ** 3 + waits_s**3))


def _continuous(
    mission: Mission, walks: tuple[Walk, ...], spent_s: list[float], speed_mps: float, traffic: Traffic
) -> Expected:
    """Return the time of steering at a rate; the periods between goals that bring the robot on are round trips too."""
    trip_s = round_trip_s(mission, traffic)
    if isinstance(trip_s, Blocked):
        return Expected("heading", None, 1, trip_s)
    took_s = [
        spent if walk.duration_s is None else steered_s(walk, mission, speed_mps, trip_s) + stands_s(walk.waypoint)
        for walk, spent in zip(walks, spent_s, strict=True)
    ]
    age_s = trip_s + mission.operator.think_s
    spare_s = max(period_s(age_s, mission.operator.update_rate_hz) - age_s - _LAST_GOAL_S, 0.0)
    return _at_once("heading", max(sum(took_s) - age_s - spare_s, SETTING_OUT_S + sum(spent_s)), 1, traffic)
