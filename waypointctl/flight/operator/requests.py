"""What an operator wants sent, before it has an id and a time, and the queue in which that waits for its time."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Generic, TypeVar

from waypointctl.flight.command_life import names
from waypointctl.log.messages import Command, CommandKind, PlannedWaypoint
from waypointctl.mission.mission import Mission
from waypointctl.mission.operator import ScheduledCommand
from waypointctl.units import ns, whole_ns

T = TypeVar("T")

LOOKAHEAD: Final = -1  # index of a place that is none of the mission's waypoints


@dataclass(slots=True)
class EventQueue(Generic[T]):
    """Things to do at a time, in the order of their times, and as they were noted where those are the same."""

    _entries: list[tuple[int, int, T]] = field(default_factory=list)  # a heap: (time, number, what)
    _noted: int = 0

    @property
    def next_ns(self) -> int | None:
        """When the first is due [ns]; None where there is none."""
        return self._entries[0][0] if self._entries else None

    def add(self, at_ns: int, what: T) -> None:
        """Note something to do."""
        self._noted += 1
        heapq.heappush(self._entries, (at_ns, self._noted, what))

    def due(self, now_ns: int) -> list[T]:
        """Take out what is due by now."""
        taken = []
        while self._entries and self._entries[0][0] <= now_ns:
            taken.append(heapq.heappop(self._entries)[2])
        return taken

    def clear(self) -> None:
        """Forget everything."""
        self._entries.clear()

    def entries(self) -> list[tuple[int, T]]:
        """Return what is noted, in order."""
        return [(at_ns, what) for at_ns, _, what in sorted(self._entries, key=lambda entry: entry[:2])]


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


def planned_waypoints(mission: Mission) -> tuple[PlannedWaypoint, ...]:
    """Return the mission's waypoints as they are commanded."""
    return tuple(
        PlannedWaypoint(
            index=leg.index,
            name=leg.name,
            x_m=leg.x_m,
            y_m=leg.y_m,
            acceptance=leg.acceptance,
            tolerance_m=leg.tolerance_m,
            timeout_ns=whole_ns(leg.timeout_s),
            hold_ns=ns(leg.hold_s),
            task="observe" if leg.observe else "",
        )
        for leg in mission.legs()
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
    values = {"set_tolerance": scheduled.tolerance_m, "set_timeout": scheduled.timeout_s}
    return values.get(scheduled.do) or 0.0
