"""A mission rehearsed on paper: the ground, the link and the executive that fly it, round a robot that is a point.

What a schedule does to a mission follows from the rules of all of them together; nothing here says a second time what
a command does. The link is as it is given, without jitter and doubling, and without losses unless they are asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final, cast

import numpy as np

from waypointctl.flight.closing import Closing
from waypointctl.flight.forecast.budget import Budget
from waypointctl.flight.forecast.walker import Walker
from waypointctl.flight.link.build import direction
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import Heartbeat
from waypointctl.flight.link.logged import DOWN, UP, LoggedDirection
from waypointctl.flight.operator.build import answer_time, leaving_time, patience_ns, station_for
from waypointctl.flight.operator.standstill import why_it_stands
from waypointctl.flight.outcome import problem_of
from waypointctl.log.messages import Ack, Command, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.policy.protocol import Policy
from waypointctl.task.observation import NOISE_SIZE
from waypointctl.units import ns, seconds

_TICK_NS: Final = 20_000_000  # the control period
_MOST_TICKS: Final = 2_000  # of a flight as it is expected; a longer one gets longer ticks
_PATIENCE: Final = 4  # times as many, for what comes between; then it is not known how it ends
_MOST_BEACONS: Final = 500  # of a flight as it is expected; they say nothing new


@dataclass(frozen=True, slots=True)
class Rehearsed:
    """How a mission went on paper.

    Attributes:
        good: whether it comes to what is expected of it, whatever time that takes.
        time_s: from mission start to the operator's knowing of the end.
        over_s: from mission start to the end of the flight, which a way home or a hold may put off.
        reached: waypoints that the operator has heard of.
        reason: why it failed, in a few words; empty where it did not.
        ends: whether it ends by itself.
    """

    good: bool
    time_s: float
    over_s: float
    reached: int
    reason: str = ""
    ends: bool = True


def rehearse(
    mission: Mission, speed_mps: float, about_s: float, budget: Budget | None = None, *, losses: bool = False
) -> Rehearsed | None:
    """Go through a mission on paper; None where no point can stand for the robot, or the end is too far off.

    Args:
        mission: what is asked; not under autonomy joint.
        speed_mps: how fast the policy walks.
        about_s: how long it takes, roughly.
        budget: of steps; one of its own if it is left out.
        losses: whether the link loses messages, as the mission's seed would have it.
    """
    if mission.autonomy == "joint":
        return None
    ticks = max(round(about_s / seconds(_TICK_NS) / _MOST_TICKS), 1)
    beacon_s = max(about_s / _MOST_BEACONS, mission.telemetry.beacon_s)
    quiet = mission.model_copy(update={"telemetry": mission.telemetry.model_copy(update={"beacon_s": beacon_s})})
    rehearsal = _Rehearsal(quiet, speed_mps, ticks * _TICK_NS, budget or Budget(), losses=losses)
    try:
        return rehearsal.run(_PATIENCE * _MOST_TICKS)
    except _BudgetSpent:
        return None


class _BudgetSpent(Exception):
    """There are no steps left."""


class _Rehearsal:
    """The state of a mission on paper."""

    def __init__(self, mission: Mission, speed_mps: float, tick_ns: int, budget: Budget, *, losses: bool) -> None:
        self._budget = budget
        self._mission, self._tick_ns, self._now_ns = mission, tick_ns, 0
        self._heard_ns = 0  # when the ground last heard or did anything
        self._known_ns: int | None = None  # when the operator ended the mission
        link, margin_ns = mission.link, ns(mission.commands.margin_s)
        up: Direction[Command | Heartbeat] = direction(link.up, mission.files, mission.seed, "link.up")
        down: Direction[Ack | Telemetry] = direction(link.down, mission.files, mission.seed, "link.down")
        for way in cast("tuple[Direction[Any], ...]", (up, down)):
            way.jitter, way.loss, way.doubling = None, way.loss if losses else None, None
        self._up, self._down = LoggedDirection(up, UP, _ignore), LoggedDirection(down, DOWN, _ignore)
        answer_by = answer_time(up, down, _TICK_NS, margin_ns)
        nobody = cast("Policy", None)  # only a pilot asks it
        noise = np.zeros(NOISE_SIZE)
        patience = patience_ns(down, margin_ns)
        send = self._up.send
        self._station = station_for(mission, nobody, noise, _ignore, send, send, answer_by, patience, leaving_time(up))
        self._walker = Walker(mission, speed_mps, self._report)
        self._closing = Closing(
            self._station, self._walker.executive, self._walker.news, up, down, self._walker.is_still
        )

    def _report(self, now_ns: int, message: Ack | Telemetry) -> None:
        self._down.send(now_ns, lambda arrives_ns: replace(message, received_ns=arrives_ns))

    def run(self, most_ticks: int) -> Rehearsed | None:
        self._station.begin()
        for _ in range(most_ticks):
            self._exchange()
            self._walker.sense(self._now_ns)
            self._exchange()
            if self._closing.is_done(self._now_ns) or self._is_late or self._closing.is_silent(self._now_ns):
                return self._end()
            next_ns = self._next_ns()
            self._walker.walk(self._now_ns, next_ns)
            self._now_ns = next_ns
        return None

    def _exchange(self) -> None:
        """Let the ground live up to now, and the robot obey what has arrived."""
        while not self._closing.is_done(self._now_ns):
            if not self._budget.spend():
                raise _BudgetSpent
            at_ns = self._ground_ns
            if at_ns is not None and at_ns <= self._now_ns:
                self._heard_ns = at_ns
                heard = next(self._down.due(at_ns), None)
                if heard is None:
                    self._station.wake(at_ns)
                else:
                    self._station.hear(at_ns, heard)
                if not self._station.finished:
                    self._known_ns = None
                elif self._known_ns is None:
                    self._known_ns = at_ns
                continue
            arrived = next(self._up.due(self._now_ns), None)
            if arrived is None:
                return
            self._walker.obey(self._now_ns, arrived)

    @property
    def _ground_ns(self) -> int | None:
        times = (self._down.direction.next_arrival_ns, self._station.wake_ns)
        return min((time for time in times if time is not None), default=None)

    def _next_ns(self) -> int:
        """Return the next control step at which something can happen."""
        if self._walker.executive.on_foot:
            return self._now_ns + self._tick_ns
        limit_s = self._mission.expect.max_time_s
        times = (
            self._ground_ns,
            self._up.direction.next_arrival_ns,
            self._walker.next_ns(self._now_ns),
            None if limit_s is None else ns(limit_s) + 1,
        )
        next_ns = min(time for time in times if time is not None)
        return max(-(-next_ns // _TICK_NS), self._now_ns // _TICK_NS + 1) * _TICK_NS

    @property
    def _is_late(self) -> bool:
        limit_s = self._mission.expect.max_time_s
        return limit_s is not None and self._now_ns > ns(limit_s)

    def _end(self) -> Rehearsed:
        station, reached = self._station, len(self._station.reached)
        known_s = seconds(self._heard_ns if self._known_ns is None else self._known_ns)
        if station.finished:
            problem, _ = problem_of(self._mission, station, over=True, late=False)
            return Rehearsed(not problem, known_s, max(known_s, self._over_s), reached, problem)
        why = why_it_stands(self._mission, station.belief.telemetry) or station.missing
        now_s = seconds(self._now_ns)
        return Rehearsed(False, now_s, now_s, reached, why, ends=bool(station.dispatcher.unanswered))

    @property
    def _over_s(self) -> float:
        """The end as a flight has it: when the last message is heard, or the control step at which all is over."""
        heard = self._now_ns - self._heard_ns < self._tick_ns
        return seconds(self._heard_ns if heard else self._now_ns)


def _ignore(_: object) -> None:
    return
