"""What an operator wants sent, before it has an id and a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from waypointctl.flight.executive.plan import names
from waypointctl.flight.operator.event_queue import EventQueue
from waypointctl.log.messages import Command, CommandKind, PlannedWaypoint
from waypointctl.mission.mission import Mission
from waypointctl.mission.operator import ScheduledCommand
from waypointctl.units import ns, whole_ns

LOOKAHEAD: Final = -1  # index of a place that is none of the mission's waypoints


@dataclass(frozen=True, slots=True)
class CommandRequest:
    """A command to be; see `Command` for what the arguments mean."""

    kind: CommandKind
    waypoints: tuple[PlannedWaypoint, ...] = ()
    on_failure: str = "abort"
    released: int = -1
    target_id: int = -1
    value: float = 0.0
    not_before_ns: int = -1
    expires_ns: int = -1
    transient: bool = False  # the next one replaces it, so its acknowledgement is not awaited

    @property
    def words(self) -> str:
        """The order in a few words."""
        parts = [self.kind.value, names(self.waypoints)]
        if self.kind in (CommandKind.SET_TOLERANCE, CommandKind.SET_TIMEOUT):
            parts.append(f"{self.value:g} {'m' if self.kind is CommandKind.SET_TOLERANCE else 's'}")
        if self.kind is CommandKind.CANCEL:
            parts.append(f"command {self.target_id}")
        if self.kind is CommandKind.RELEASE:
            parts.append("all" if self.released < 0 else str(self.released))
        return " ".join(part for part in parts if part)

    def command(self, command_id: int, attempt: int, issued_ns: int, received_ns: int) -> Command:
        """Return the order as it arrives."""
        return Command(
            id=command_id,
            kind=self.kind,
            waypoints=self.waypoints,
            on_failure=self.on_failure,
            issued_ns=issued_ns,
            received_ns=received_ns,
            attempt=attempt,
            released=self.released,
            target_id=self.target_id,
            value=self.value,
            not_before_ns=self.not_before_ns,
            expires_ns=self.expires_ns,
        )


def scheduled_requests(mission: Mission) -> EventQueue[CommandRequest]:
    """Return the mission's scheduled commands, each at its time."""
    queue: EventQueue[CommandRequest] = EventQueue()
    for scheduled in mission.schedule:
        queue.add(ns(scheduled.at_s), request_of(scheduled, mission))
    return queue


def request_of(scheduled: ScheduledCommand, mission: Mission) -> CommandRequest:
    """Return a scheduled command as an order; what a place leaves open is taken from the mission's defaults."""
    return CommandRequest(
        kind=CommandKind(scheduled.do),
        waypoints=() if scheduled.position_m is None else (place(scheduled.position_m, mission, scheduled),),
        released=-1 if scheduled.released is None else scheduled.released,
        target_id=-1 if scheduled.command is None else scheduled.command,
        value=_value(scheduled),
        not_before_ns=-1 if scheduled.not_before_s is None else ns(scheduled.not_before_s),
        expires_ns=-1 if scheduled.expires_s is None else ns(scheduled.expires_s),
    )


def place(position_m: Sequence[float], mission: Mission, scheduled: ScheduledCommand | None = None) -> PlannedWaypoint:
    """Return a place that is none of the mission's waypoints, (x, y) in [m]."""
    defaults = mission.defaults
    tolerance_m = scheduled.tolerance_m if scheduled else None
    timeout_s = scheduled.timeout_s if scheduled else None
    hold_s = scheduled.hold_s if scheduled else None
    return PlannedWaypoint(
        index=LOOKAHEAD,
        name=f"({position_m[0]:g}, {position_m[1]:g})",
        x_m=position_m[0],
        y_m=position_m[1],
        acceptance=defaults.acceptance,
        tolerance_m=defaults.tolerance_m if tolerance_m is None else tolerance_m,
        timeout_ns=whole_ns(defaults.timeout_s if timeout_s is None else timeout_s),
        hold_ns=ns(defaults.hold_s if hold_s is None else hold_s),
    )


def _value(scheduled: ScheduledCommand) -> float:
    if scheduled.do == "set_tolerance":
        return scheduled.tolerance_m or 0.0
    return scheduled.timeout_s or 0.0 if scheduled.do == "set_timeout" else 0.0
