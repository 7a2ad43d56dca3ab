"""The legs of a flight, to waypoints and home: when each began, how it ended, and when the operator knew of that."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, Final

from waypointctl.flight.command_life import FLIGHT_ENDED
from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Clock,
    Command,
    CommandKind,
    CommandStage,
    Event,
    EventKind,
    Mode,
    PlannedWaypoint,
    Stage,
    Telemetry,
)
from waypointctl.replay.track import is_on_map
from waypointctl.units import seconds


class WaypointStatus(StrEnum):
    """Whether a waypoint was reached, and why not."""

    REACHED = "reached"
    TIMED_OUT = "timed out"
    SKIPPED = "skipped"
    OPEN = "not reached"


@dataclass(frozen=True, slots=True)
class WaypointSummary:
    """A waypoint, and whether it was reached."""

    planned: PlannedWaypoint  # as it was, or would have been, commanded
    status: WaypointStatus = WaypointStatus.OPEN  # as the robot knows it
    started_ns: int | None = None  # when the robot's leg to it began, None if it never did
    ended_ns: int | None = None  # when it was reached or given up, None for a leg that was under way to the end
    reached_ns: int | None = None  # on the robot's clock
    known_ns: int | None = None  # when the operator learned that it was reached

    @property
    def is_on_map(self) -> bool:
        """Whether it can be drawn."""
        return is_on_map(self.planned.x_m, self.planned.y_m, self.planned.tolerance_m)


_STATUSES: Final = {
    EventKind.WAYPOINT_REACHED: WaypointStatus.REACHED,
    EventKind.WAYPOINT_TIMEOUT: WaypointStatus.TIMED_OUT,
    EventKind.WAYPOINT_SKIPPED: WaypointStatus.SKIPPED,
}
# What the robot does instead of driving on to a waypoint.
_ENDS_A_LEG: Final = frozenset(
    {
        EventKind.FALL,
        EventKind.LEG_STARTED,
        EventKind.PLAN_COMPLETED,
        EventKind.PLAN_FAILED,
        EventKind.RETURN_STARTED,
        EventKind.TELEOPERATION_STARTED,
    }
)


class WaypointsBuilder:
    """Makes the waypoints of a flight out of its messages."""

    def __init__(self, planned: Iterable[PlannedWaypoint]) -> None:
        """Begin with the waypoints of the mission, where they are known beforehand."""
        self._waypoints = {waypoint.index: WaypointSummary(waypoint) for waypoint in planned}
        self._places: dict[tuple[float, float], PlannedWaypoint] = {}
        self._leg: int | None = None  # the waypoint of the leg that began last
        self._known = 0  # how many of the waypoints in telemetry's `reached`, which only grows, have been taken

    @property
    def waypoints(self) -> tuple[WaypointSummary, ...]:
        """The waypoints so far, in order."""
        return tuple(waypoint for _, waypoint in sorted(self._waypoints.items()))

    @property
    def places(self) -> tuple[PlannedWaypoint, ...]:
        """The commanded places that are none of the waypoints, each once."""
        return tuple(self._places.values())

    def on_command(self, command: Command) -> None:
        """Take a command that has arrived on board."""
        for waypoint in command.waypoints:
            if waypoint.index < 0:
                self._places.setdefault((waypoint.x_m, waypoint.y_m), waypoint)
            elif waypoint.index not in self._waypoints:
                self._waypoints[waypoint.index] = WaypointSummary(waypoint)

    def on_report(self, frame: Telemetry) -> None:
        """Take a frame of telemetry that has arrived at the operator."""
        for index in frame.reached[self._known :]:
            waypoint = self._waypoints.get(index)
            if waypoint is not None and waypoint.known_ns is None:
                self._waypoints[index] = replace(waypoint, known_ns=frame.received_ns)
        self._known = max(self._known, len(frame.reached))

    def on_event(self, event: Event) -> None:
        """Take an event."""
        if event.kind in _ENDS_A_LEG and self._leg is not None:
            leg = self._waypoints[self._leg]
            if leg.ended_ns is None:
                self._waypoints[self._leg] = replace(leg, ended_ns=event.time_ns)
        waypoint = self._waypoints.get(event.waypoint)
        if waypoint is None:
            return
        changes: dict[str, Any] = {"status": _STATUSES.get(event.kind, waypoint.status)}
        if event.kind is EventKind.LEG_STARTED:
            self._leg = event.waypoint
            changes |= {"started_ns": event.time_ns, "ended_ns": None}
        elif event.kind in (EventKind.WAYPOINT_REACHED, EventKind.WAYPOINT_TIMEOUT):
            changes["ended_ns"] = event.time_ns
            if event.kind is EventKind.WAYPOINT_REACHED:
                changes["reached_ns"] = event.time_ns
        self._waypoints[event.waypoint] = replace(waypoint, **changes)


class ReturnEnding(StrEnum):
    """How a way home ended."""

    REACHED = "home reached"
    FAILED = "home not reached"
    FALLEN = "fell on the way home"
    CALLED_OFF = "called off by another command"
    OPEN = "under way when the flight ended"


_ENDINGS: Final = {
    EventKind.HOME_REACHED: ReturnEnding.REACHED,
    EventKind.RETURN_FAILED: ReturnEnding.FAILED,
    EventKind.PLAN_FAILED: ReturnEnding.FAILED,
    EventKind.FALL: ReturnEnding.FALLEN,
    EventKind.LEG_STARTED: ReturnEnding.CALLED_OFF,
    EventKind.RELEASE_AWAITED: ReturnEnding.CALLED_OFF,
    EventKind.TELEOPERATION_STARTED: ReturnEnding.CALLED_OFF,
    EventKind.RETURN_STARTED: ReturnEnding.CALLED_OFF,
}


@dataclass(frozen=True, slots=True)
class ReturnHome:
    """A way home. Times are in [ns]: what happened on the robot's clock, what was learned on the operator's."""

    began_ns: int  # when it began
    cause: str  # the rule that began it, such as "timeout"; or the command
    command_id: int | None  # the command that began it; None for a rule
    ended_ns: int | None = None  # when it ended; None for one that was under way to the end
    ending: ReturnEnding = ReturnEnding.OPEN  # how it ended
    began_known_ns: int | None = None  # when the operator learned that it had begun; None for never
    ended_known_ns: int | None = None  # when the operator learned that it had ended; None for never

    def __str__(self) -> str:
        """Return when and why it began, and how it ended."""
        ended = "" if self.ended_ns is None else f" at {seconds(self.ended_ns):.2f} s"
        return f"began at {seconds(self.began_ns):.2f} s ({self.cause}), {self.ending}{ended}"


class ReturnsBuilder:
    """Makes the returns home out of a flight's messages."""

    def __init__(self) -> None:
        """Begin without any."""
        self._returns: list[ReturnHome] = []

    @property
    def returns(self) -> tuple[ReturnHome, ...]:
        """Those so far, in order."""
        return tuple(self._returns)

    def on_event(self, event: Event) -> None:
        """Take an event."""
        ending = _ENDINGS.get(event.kind)
        if ending is not None:
            self._end(event.time_ns, ending)
        if event.kind is EventKind.RETURN_STARTED:
            cause = event.text.partition(": ")[2]
            command_id = None if cause else event.command_id
            self._returns.append(ReturnHome(event.time_ns, cause or f"command {command_id}", command_id))

    def on_stage(self, it: CommandStage, kind: CommandKind | None) -> None:
        """Take a stage of a command of some kind."""
        current = self._current
        if current is None or it.clock is not Clock.ROBOT or it.stage not in FINAL_STAGES or it.reason == FLIGHT_ENDED:
            return
        is_taken_back = it.command_id == current.command_id and it.stage is not Stage.COMPLETED
        is_aborted = current.command_id is None and kind is CommandKind.ABORT and it.stage is Stage.COMPLETED
        if is_taken_back or is_aborted:
            self._end(it.time_ns, ReturnEnding.CALLED_OFF)

    def on_report(self, message: Telemetry | Ack) -> None:
        """Take what has arrived at the operator: what had happened when it was issued is known from then on."""
        # The end of the return before the newest may still be news.
        self._returns[-2:] = [_reported(each, message) for each in self._returns[-2:]]

    @property
    def _current(self) -> ReturnHome | None:
        return self._returns[-1] if self._returns and self._returns[-1].ended_ns is None else None

    def _end(self, time_ns: int, ending: ReturnEnding) -> None:
        if self._current is not None:
            self._returns[-1] = replace(self._returns[-1], ended_ns=time_ns, ending=ending)


def _reported(each: ReturnHome, message: Telemetry | Ack) -> ReturnHome:
    """Return a return home with what a message reports of it."""
    if isinstance(message, Ack):
        is_its_own = message.command_id == each.command_id
        reports_begin = is_its_own and message.stage is Stage.STARTED
        reports_end = is_its_own and message.stage in FINAL_STAGES
    else:
        reports_begin = message.mode is Mode.RETURNING
        reports_end = not reports_begin
    if reports_begin and each.began_known_ns is None and message.issued_ns >= each.began_ns:
        each = replace(each, began_known_ns=message.received_ns)
    is_news = reports_end and each.ended_known_ns is None and each.ended_ns is not None
    if is_news and each.ended_ns is not None and message.issued_ns >= each.ended_ns:
        each = replace(each, ended_known_ns=message.received_ns)
    return each
