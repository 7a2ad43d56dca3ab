"""Operators that send waypoints: the whole plan at once, or one waypoint after the other."""

from __future__ import annotations

from collections.abc import Callable

from waypointctl.flight.operator.operator import Operator, ended_by_robot, leg_failed, rule_of_leg
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.log.messages import Ack, CommandKind, Event, EventKind, Stage
from waypointctl.mission.mission import Mission


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
        return self._after_think(now_ns, self._next()) if self._sent < len(self._plan) else self._finish()
