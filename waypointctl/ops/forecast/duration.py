"""How long a mission takes under each autonomy: T = L / v + N (RTT + think), with each exchange at its own time.

L is the way and v the policy's mean speed; N is how often the operator has to hear before it can say what is next. A
round trip is what the link makes of it when its time comes, with its windows and rates, without jitter and loss. What a
schedule of commands adds is not in it, nor that an operator who steers gives a leg up when its time is out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final, Literal, TypeAlias

from waypointctl.log.messages import PlannedWaypoint
from waypointctl.mission.mission import Mission
from waypointctl.ops.executive.judgement import OBSERVATION_NS, OBSERVE
from waypointctl.ops.forecast.joint import falls
from waypointctl.ops.forecast.release import waits_for_ever
from waypointctl.ops.forecast.traffic import ACK_BYTES, Traffic, go_to_bytes, upload_bytes
from waypointctl.ops.ground.operator import planned_waypoints
from waypointctl.units import ns, seconds

Autonomy: TypeAlias = Literal["mission", "waypoint", "heading", "joint"]
AUTONOMIES: Final[tuple[Autonomy, ...]] = ("mission", "waypoint", "heading", "joint")

_NEAR_CARROT: Final = 0.25  # of its distance: within this a short-range goal counts as reached
_MOST_CARROTS: Final = 20_000  # that are worked out one by one; more take as much longer as they are more


@dataclass(frozen=True, slots=True)
class Walk:
    """A leg as it is expected.

    Attributes:
        waypoint: that it leads to.
        way_m: how far that is.
        duration_s: from setting out to having held and observed there; None where its time is out before it is reached.
    """

    waypoint: PlannedWaypoint
    way_m: float
    duration_s: float | None


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
        time_s: from the first command to the operator's knowing of the end; None for never.
        exchanges: how often the operator has to hear before it can say what is next.
        blocked: the message that never gets through, where that is why the time is None.
        falls: whether the robot is expected to fall, which is why the time is None.
    """

    autonomy: Autonomy
    time_s: float | None
    exchanges: int
    blocked: Blocked | None = None
    falls: bool = False


def walks_of(mission: Mission, speed_mps: float) -> tuple[Walk, ...]:
    """Return the legs that the robot sets out on, from where it is expected to be.

    One whose time is too short is given up on its way; unless the mission goes on then, it is the last.
    """
    place, rule = mission.start.position_m, mission.failure_rule
    walks = []
    for waypoint in planned_waypoints(mission):
        way_m = math.dist(place, (waypoint.x_m, waypoint.y_m))
        walked_m = seconds(waypoint.timeout_ns) * (1 + rule.retry) * speed_mps
        if way_m <= walked_m:
            walks.append(Walk(waypoint, way_m, way_m / speed_mps + stands_s(waypoint)))
            place = (waypoint.x_m, waypoint.y_m)
            continue
        walks.append(Walk(waypoint, way_m, None))
        if rule.then != "skip":
            break
        part = walked_m / way_m
        place = (place[0] + part * (waypoint.x_m - place[0]), place[1] + part * (waypoint.y_m - place[1]))
    return tuple(walks)


def stands_s(waypoint: PlannedWaypoint) -> float:
    """Return how long the robot stands at a waypoint for its hold and its task [s]."""
    return seconds(waypoint.hold_ns + (OBSERVATION_NS if waypoint.task == OBSERVE else 0))


def expected(mission: Mission, speed_mps: float, traffic: Traffic, autonomy: Autonomy) -> Expected:
    """Return how long a mission takes under an autonomy, its own or another."""
    walks = walks_of(mission, speed_mps)
    retry = 1 + mission.failure_rule.retry
    spent_s = [
        seconds(walk.waypoint.timeout_ns) * retry if walk.duration_s is None else walk.duration_s for walk in walks
    ]
    if autonomy == "mission" and waits_for_ever(mission):
        return Expected(autonomy, None, 1)
    if autonomy == "mission":
        return _at_once(autonomy, sum(spent_s), upload_bytes(mission), traffic)
    if autonomy == "joint" and falls(traffic):
        return Expected(autonomy, None, 1, falls=True)
    if autonomy == "joint":
        return _at_once(autonomy, sum(spent_s), 1, traffic)
    steered = autonomy == "heading"
    if steered and mission.operator.steering == "continuous":
        return _continuous(mission, walks, spent_s, speed_mps, traffic)
    if steered:
        counts, heard = steered_moves(mission, walks, spent_s, traffic)
    else:
        counts = [1] * len(walks)
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
    counts = [moves_of(walk, mission) for walk in walks]
    moves = islice(_moves(walks, spent_s, counts), _MOST_CARROTS)
    return counts, [*_in_turn(moves, traffic, ns(mission.operator.think_s))]


def moves_of(walk: Walk, mission: Mission) -> int:
    """Return of how many short moves a leg is made, steering by move and wait."""
    carrot_m = mission.operator.carrot_m
    step_m = carrot_m - min(walk.waypoint.tolerance_m, carrot_m * _NEAR_CARROT)
    return max(math.ceil((walk.way_m - carrot_m) / step_m), 0) + 1


def pose_age_s(mission: Mission, traffic: Traffic) -> float | Blocked:
    """Return how old, steering at a rate, the pose behind a goal is when the next goal takes its place [s]."""
    (heard,) = _in_turn([(0.0, go_to_bytes(planned_waypoints(mission)[0]))], traffic, 0)
    return heard if isinstance(heard, Blocked) else seconds(heard) + 1 / mission.operator.update_rate_hz


def slower_by(age_s: float, mission: Mission, speed_mps: float) -> float:
    """Return how many times as long a way takes that is steered at a rate, from poses of some age.

    A goal ahead of an old pose bounds the speed: within its age the robot comes to where the goal counts as reached,
    and no further.
    """
    carrot_m = mission.operator.carrot_m
    near_m = min(carrot_m * _NEAR_CARROT, *(waypoint.tolerance_m for waypoint in planned_waypoints(mission)))
    return max(speed_mps * age_s / (carrot_m - near_m), 1.0)


def _continuous(
    mission: Mission, walks: tuple[Walk, ...], spent_s: list[float], speed_mps: float, traffic: Traffic
) -> Expected:
    """Return the time of steering at a rate."""
    age_s = pose_age_s(mission, traffic)
    if isinstance(age_s, Blocked):
        return Expected("heading", None, 1, age_s)
    slower = slower_by(age_s, mission, speed_mps)
    holds_s = sum(stands_s(walk.waypoint) for walk in walks if walk.duration_s is not None)
    return _at_once("heading", (sum(spent_s) - holds_s) * slower + holds_s, 1, traffic)
