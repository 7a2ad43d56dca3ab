"""Operators that send waypoints: the whole plan at once, one waypoint after the other, or goals near the robot.

A goal near the robot lies `lookahead` metres from its last reported pose towards the current waypoint; nearer than that
the waypoint itself is sent. Under `move_and_wait` the next one is sent when the last is reported as over, after the
think time. Under `continuous` one is sent at each period, in place of the one before, from the newest reported pose.

A leg's timeout counts the robot's time, as on board (timing.py): delay and think time before the leg begins are not
in it. The time that the robot is stopped between the goals of one leg is.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from waypointctl.flight.executive.rules import FALL, TIMEOUT
from waypointctl.flight.operator.operator import Operator, ended_by_robot, leg_failed, rule_of_leg
from waypointctl.flight.operator.requests import LOOKAHEAD, CommandRequest
from waypointctl.flight.operator.timing import LegClock
from waypointctl.log.messages import Ack, CommandKind, Event, EventKind, PlannedWaypoint, Stage, Telemetry
from waypointctl.mission.fields import FURTHEST_M
from waypointctl.mission.mission import Mission
from waypointctl.units import NS_PER_S

_NEAR_GOAL: Final = 0.25  # of its distance: within this the goal counts as reached


class MissionOperator(Operator):
    """Sends the whole plan once and waits: autonomy `mission`."""

    def __init__(self, mission: Mission, announce: Callable[[Event], None] = lambda _: None) -> None:
        """Start a mission; `announce` takes the operator's events."""
        super().__init__(mission, announce)
        self._on_failure: str = mission.failure_rule.then
        self._released = mission.operator.released

    def begin(self) -> list[CommandRequest]:
        """Send the plan, with the number of released waypoints that the mission sets."""
        return [CommandRequest(CommandKind.UPLOAD_PLAN, self._plan, self._on_failure, self._released)]

    def _on_final(self, now_ns: int, ack: Ack) -> list[CommandRequest]:
        return (
            self._finish(ended_by_robot(ack, self._kinds))
            if ack.command_id == self._newest.get(CommandKind.UPLOAD_PLAN)
            else []
        )


class WaypointOperator(Operator):
    """Autonomy `waypoint`: sends one waypoint, waits for its end and the think time, sends the next."""

    def __init__(self, mission: Mission, announce: Callable[[Event], None] = lambda _: None) -> None:
        """Start a mission; `announce` takes the operator's events."""
        super().__init__(mission, announce)
        self._skips = mission.failure_rule.then == "skip"
        self._rule = rule_of_leg(mission)
        self._sent = 0
        self._put_off: list[CommandRequest] = []  # until it is known that the robot does not return home

    def begin(self) -> list[CommandRequest]:
        """Send the first waypoint."""
        return [self._next()]

    def _next(self) -> CommandRequest:
        waypoint = self._plan[self._sent]
        self._sent += 1
        return CommandRequest(CommandKind.GO_TO, (waypoint,), self._rule)

    def _on_final(self, now_ns: int, ack: Ack) -> list[CommandRequest]:
        if ack.command_id != self._newest.get(CommandKind.GO_TO):
            return []
        if self._skips and leg_failed(ack):
            self._announce_decision(
                now_ns, EventKind.WAYPOINT_SKIPPED, self._plan[self._sent - 1], f"skipped: {ack.reason}"
            )
        elif ack.stage is not Stage.COMPLETED:
            return self._finish(ended_by_robot(ack, self._kinds))
        if self._sent == len(self._plan):
            return self._finish()
        return self._unless_going_home(self._after_think(now_ns, self._next()))

    def wake(self, now_ns: int) -> list[CommandRequest]:
        """Send what is due after the think time."""
        return self._unless_going_home(super().wake(now_ns))

    def _unless_going_home(self, requests: list[CommandRequest]) -> list[CommandRequest]:
        if not self.going_home:
            return requests
        self._put_off += requests
        return []

    def _resume(self, now_ns: int) -> list[CommandRequest]:
        put_off, self._put_off = self._put_off, []
        return put_off


class ShortRangeGoalOperator(Operator):
    """Leads the robot by short-range goals."""

    def __init__(
        self,
        mission: Mission,
        clock: LegClock | None = None,
        announce: Callable[[Event], None] = lambda _: None,
    ) -> None:
        """Start a mission.

        Args:
            mission: the mission.
            clock: of its legs; without it the answer to what leaves is there at once.
            announce: takes what it decides.
        """
        super().__init__(mission, announce)
        script = mission.operator
        self._rule = rule_of_leg(mission)
        self._skips = mission.failure_rule.then == "skip"
        self._continuous = script.steering == "continuous"
        self._lookahead_m = script.lookahead_m
        self._period_ns = round(NS_PER_S / script.update_rate_hz)
        self._start = mission.start.position_m
        self._put_off = False  # a goal is due that a hold kept back
        self._at_task = False  # a waypoint with a hold or an observation is under way
        self._leg = 0
        self._clock = clock or LegClock(lambda left_ns: left_ns)
        # When the next goal is due under `continuous`.
        self._next_goal_ns: int | None = self._period_ns if self._continuous else None

    @property
    def wake_ns(self) -> int | None:
        """When it wants to act next, if nothing arrives before [ns]."""
        goal_ns = None if self.suspended or self._at_task else self._next_goal_ns
        times = [time for time in (self._queue.next_ns, goal_ns) if time is not None]
        return None if self.finished else min(times, default=None)

    def begin(self) -> list[CommandRequest]:
        """Send the first goal."""
        return [self._lookahead_goal()]

    def on_issued(self, command_id: int, request: CommandRequest) -> None:
        """Learn the id of a request that has been sent."""
        super().on_issued(command_id, request)
        self._clock.on_issued(command_id, request)

    def on_message(self, now_ns: int, message: Ack | Telemetry) -> list[CommandRequest]:
        """Process what has arrived; under continuous steering a report of the waypoint begins the next leg."""
        self._clock.on_message(message)
        requests = super().on_message(now_ns, message)
        if self._continuous and not self.finished and not self._at_task and self._leg_is_over():
            return requests + self._next_leg(now_ns)
        return requests

    def wake(self, now_ns: int) -> list[CommandRequest]:
        """Send what is due: after the think time, or the period's goal."""
        requests = self._unless_suspended(self._queue.due(now_ns))
        if self._next_goal_ns is None or self._next_goal_ns > now_ns or self.suspended or self._at_task:
            return requests
        self._next_goal_ns += self._period_ns
        if self._is_out_of_time(now_ns) and not self._leg_is_over():
            return requests + self._give_up_leg(now_ns, TIMEOUT)
        return requests + self._after_think(now_ns, self._lookahead_goal())

    def _on_final(self, now_ns: int, ack: Ack) -> list[CommandRequest]:
        if ack.reason == FALL:
            return self._finish(FALL)
        if self.finished or ack.command_id != self._newest.get(CommandKind.GO_TO):
            return []
        if self._continuous and not self._at_task:
            return []
        if ack.stage is Stage.COMPLETED:
            if self._leg_is_over():
                return self._next_leg(now_ns)
            if self._clock.is_over(self._plan[self._leg].timeout_ns):
                return self._give_up_leg(now_ns, TIMEOUT)
            return self._unless_suspended(self._after_think(now_ns, self._lookahead_goal()))
        return (
            self._give_up_leg(now_ns, ack.reason) if leg_failed(ack) else self._finish(ended_by_robot(ack, self._kinds))
        )

    def _is_out_of_time(self, now_ns: int) -> bool:
        """Return whether the robot's time for the leg is over, or a report of it is overdue."""
        timeout_ns = self._plan[self._leg].timeout_ns
        return self._clock.is_over(timeout_ns) or self._clock.is_silent(now_ns, timeout_ns)

    def _leg_is_over(self) -> bool:
        return self.reported.knows_reached(self._plan[self._leg].index)

    def _give_up_leg(self, now_ns: int, code: str) -> list[CommandRequest]:
        if not self._skips:
            return self._finish(code)
        self._announce_decision(now_ns, EventKind.WAYPOINT_SKIPPED, self._plan[self._leg], f"skipped: {code}")
        return self._next_leg(now_ns)

    def _next_leg(self, now_ns: int) -> list[CommandRequest]:
        if self._leg + 1 == len(self._plan):
            return self._finish()
        self._leg, self._at_task = self._leg + 1, False
        self._skip_missed_goals(now_ns)
        self._clock.restart((now_ns if self._next_goal_ns is None else self._next_goal_ns) + self._think_ns)
        return [] if self._continuous else self._unless_suspended(self._after_think(now_ns, self._lookahead_goal()))

    def _unless_suspended(self, requests: list[CommandRequest]) -> list[CommandRequest]:
        """Return what to send, or put it off until the hold is over."""
        if not self.suspended:
            return requests
        self._put_off = self._put_off or bool(requests)
        return []

    def _skip_missed_goals(self, now_ns: int) -> None:
        """Skip the update times that have passed: there were no updates during a hold or a task."""
        if self._next_goal_ns is not None and self._next_goal_ns < now_ns:
            self._next_goal_ns -= (self._next_goal_ns - now_ns) // self._period_ns * self._period_ns

    def _resume(self, now_ns: int) -> list[CommandRequest]:
        self._skip_missed_goals(now_ns)
        self._clock.restart(now_ns)
        put_off, self._put_off = self._put_off, False
        return [self._lookahead_goal()] if put_off else []

    def _lookahead_goal(self) -> CommandRequest:
        waypoint, frame = self._plan[self._leg], self.reported.telemetry
        x_m, y_m = self._start if frame is None else (frame.x_m, frame.y_m)
        distance_m = math.dist((x_m, y_m), (waypoint.x_m, waypoint.y_m))
        if distance_m <= self._lookahead_m:
            # Where there is something to do the robot is not to be called away from it.
            self._at_task = bool(waypoint.hold_ns or waypoint.task)
            transient = self._continuous and not self._at_task
            return self._clock.include(CommandRequest(CommandKind.GO_TO, (waypoint,), self._rule, transient=transient))
        part = self._lookahead_m / distance_m
        place = PlannedWaypoint(
            index=LOOKAHEAD,
            name=f"towards {waypoint.name}",
            x_m=_in_bounds(x_m + part * (waypoint.x_m - x_m)),
            y_m=_in_bounds(y_m + part * (waypoint.y_m - y_m)),
            acceptance=waypoint.acceptance,
            tolerance_m=min(waypoint.tolerance_m, self._lookahead_m * _NEAR_GOAL),
            timeout_ns=waypoint.timeout_ns,
            hold_ns=0,
        )
        request = CommandRequest(CommandKind.GO_TO, (place,), self._rule, transient=self._continuous)
        return self._clock.include(request)


def _in_bounds(coordinate_m: float) -> float:
    """Return a coordinate that the robot accepts: one that has overshot a waypoint at the edge may be beyond it."""
    return min(max(coordinate_m, -FURTHEST_M), FURTHEST_M)
