"""The scripted operator on the ground: it decides from reported state alone, and sends after the think time."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from waypointctl.flight.executive.rules import AT_HOME, STUCK, TIMEOUT
from waypointctl.flight.operator.requests import CommandRequest, EventQueue, planned_waypoints
from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Clock,
    CommandKind,
    Event,
    EventKind,
    Mode,
    PlannedWaypoint,
    Severity,
    Stage,
    Telemetry,
)
from waypointctl.mission.mission import Mission
from waypointctl.units import ns

# Ended by another command or by the clock: the reason alone names the command or the time, not the stage.
_BY_ANOTHER: Final = frozenset({Stage.CANCELLED, Stage.SUPERSEDED, Stage.EXPIRED, Stage.SKIPPED})
_COMMAND: Final = re.compile(r"\bby command ([0-9]{1,18})$")


@dataclass(slots=True)
class ReportedState:
    """What the robot has reported."""

    telemetry: Telemetry | None = None  # the newest frame that has arrived; None before the first
    went_home: bool = False  # whether a way home has been reported
    ended_ns: int = -1  # when, on the robot's clock, the command ended whose end was reported last; -1 before the first
    _reached: set[int] = field(default_factory=set)

    @property
    def reached(self) -> tuple[int, ...]:
        """The waypoints that the robot has reported as reached."""
        return self.telemetry.reached if self.telemetry else ()

    def knows_reached(self, index: int) -> bool:
        """Return whether the robot has reported a waypoint as reached."""
        return index in self._reached

    @property
    def is_current(self) -> bool:
        """Whether a frame has arrived that is no older than the last end reported: the one before it may be lost."""
        return self.ended_ns < 0 or (self.telemetry is not None and self.telemetry.issued_ns >= self.ended_ns)

    def on_message(self, message: Ack | Telemetry) -> None:
        """Take what has arrived."""
        if isinstance(message, Ack):
            if message.stage in FINAL_STAGES:
                self.ended_ns = max(self.ended_ns, message.issued_ns)
            return
        if self.telemetry is None or message.frame >= self.telemetry.frame:  # ignore frames that arrive out of order
            self.telemetry = message
            self._reached.update(message.reached[len(self._reached) :])  # what is reached stays so, in its order
        self.went_home = self.went_home or message.mode is Mode.RETURNING or message.cause.startswith(AT_HOME)


class Operator(ABC):
    """Commands the robot. It knows only what has arrived on the downlink.

    Each method takes the time and returns the requests to send at that time. `on_issued` gives their ids.

    Attributes:
        reported: what the robot has reported.
        finished: whether it has ended the mission.
        failure: why, where that is a failure.
        suspended: whether it sends no goals or actions now, because of a hold or a return home.
        going_home: whether the robot is at home, or on its way there, by a command from the schedule or the console.
    """

    def __init__(self, mission: Mission, announce: Callable[[Event], None] = lambda _: None) -> None:
        """Start a mission; `announce` takes the operator's events."""
        self._announce = announce
        self.reported = ReportedState()
        self.finished = False
        self.failure = ""
        self.suspended = self.going_home = False
        self._home_ns: int | None = None  # when a return home is to start that was commanded from elsewhere
        self._plan = planned_waypoints(mission)
        self._think_ns = ns(mission.operator.think_s)
        self._queue: EventQueue[CommandRequest] = EventQueue()
        self._newest: dict[CommandKind, int] = {}  # the newest command of each kind
        self._kinds: dict[int, CommandKind] = {}  # of every command sent, also from the schedule or the console

    @property
    def wake_ns(self) -> int | None:
        """When it wants to act next, if nothing arrives before [ns]; None for never."""
        return self._queue.next_ns

    @property
    def reached(self) -> tuple[int, ...]:
        """The waypoints that it knows to be reached: their indices in the mission."""
        return self.reported.reached

    @abstractmethod
    def begin(self) -> list[CommandRequest]:
        """Return what to send at mission start; the plan needs no think time."""

    def on_external_request(self, now_ns: int, request: CommandRequest) -> list[CommandRequest]:
        """Learn what the schedule, or a person at the console, has sent; return what to send because of it.

        An operator who leads the robot step by step stops leading it for a hold, until it is to be resumed, and for a
        return home. Where the plan is on board the robot itself does that.
        """
        if request.kind is CommandKind.RETURN_HOME:
            self._home_ns = request.not_before_ns
            self.yield_to_return(now_ns, lambda sent_ns: sent_ns)
        elif request.kind is CommandKind.HOLD:
            self.suspended = True
        elif request.kind is CommandKind.RESUME:
            self.suspended = self.going_home = False
            return self._resume(now_ns)
        return []

    def yield_to_return(self, now_ns: int, arrival_ns: Callable[[int], int | None]) -> None:
        """Lead no further once what is sent would, by its latest arrival, call the robot back from its way home.

        `arrival_ns` is when what is sent at a time [ns] arrives at the latest [ns]; None for never.
        """
        if self._home_ns is None:
            return
        arrives_ns = arrival_ns(now_ns)
        if arrives_ns is None or arrives_ns >= self._home_ns:
            self.suspended, self.going_home, self._home_ns = True, True, None

    def _resume(self, now_ns: int) -> list[CommandRequest]:
        """Return what to send after a hold."""
        return []

    def on_issued(self, command_id: int, request: CommandRequest) -> None:
        """Learn the id of a request that has been sent."""
        self._newest[request.kind] = command_id

    def note_kind(self, command_id: int, kind: CommandKind) -> None:
        """Learn the kind of a command that has been sent, by whomever."""
        self._kinds[command_id] = kind

    def on_message(self, now_ns: int, message: Ack | Telemetry) -> list[CommandRequest]:
        """Take what has arrived; return what to send on hearing it."""
        self.reported.on_message(message)
        if not isinstance(message, Ack) or message.stage not in FINAL_STAGES:
            return []
        if self._kinds.get(message.command_id) is CommandKind.RETURN_HOME and not self.finished:
            return self._after_return(now_ns, message)
        return self._on_final(now_ns, message)

    def _after_return(self, now_ns: int, ack: Ack) -> list[CommandRequest]:
        """End the mission after a return home commanded from elsewhere; lead on where the robot did not go."""
        self._home_ns = None
        if not self.going_home:
            return []
        if ack.stage in (Stage.COMPLETED, Stage.FAILED, Stage.SUPERSEDED):
            return self._finish(ack.reason or f"command {ack.command_id} ({CommandKind.RETURN_HOME}) ended the mission")
        self.suspended = self.going_home = False
        return self._resume(now_ns)

    def wake(self, now_ns: int) -> list[CommandRequest]:
        """Return what to send now."""
        return self._queue.due(now_ns)

    @property
    def newest(self) -> tuple[int, ...]:
        """Its newest command of each kind, in the order of issue."""
        return tuple(sorted(self._newest.values()))

    @property
    def acts_on_states(self) -> bool:
        """Whether every state of the robot that arrives may make it send something."""
        return False

    def state(self) -> dict[str, object]:
        """Return what it will do next depends on, beside what was reported, as plain data."""
        return {
            "finished": self.finished,
            "queue": [[at_ns, request.words] for at_ns, request in self._queue.entries()],
        }

    @abstractmethod
    def _on_final(self, now_ns: int, ack: Ack) -> list[CommandRequest]:
        """Decide what follows the end of a command."""

    def _after_think(self, now_ns: int, request: CommandRequest) -> list[CommandRequest]:
        """Send a request after the think time."""
        if not self._think_ns:
            return [request]
        self._queue.add(now_ns + self._think_ns, request)
        return []

    def _announce_decision(
        self, now_ns: int, kind: EventKind, waypoint: PlannedWaypoint, text: str, severity: Severity = Severity.WARNING
    ) -> None:
        """Announce a decision about a waypoint."""
        self._announce(Event(now_ns, kind, Clock.OPERATOR, severity, f"{waypoint.name} {text}", waypoint.index))

    def _finish(self, failure: str = "") -> list[CommandRequest]:
        self.finished, self.failure = True, failure
        self._queue.clear()
        return []


def leg_failed(ack: Ack) -> bool:
    """Return whether a waypoint was not reached, by a robot that can still drive to another."""
    return ack.stage is Stage.FAILED and ack.reason in (TIMEOUT, STUCK)


def rule_of_leg(mission: Mission) -> str:
    """Return the robot's `on_failure` for a single waypoint's command; empty: its own rules apply.

    To skip it, or to end the mission, is for the operator to decide, who has the rest of the plan.
    """
    return "" if mission.failure_rule.then in ("hold", "return_home") else "abort"


def ended_by_robot(ack: Ack, kinds: Mapping[int, CommandKind]) -> str:
    """Return why a command that did not complete ended, in a few words; `kinds` are of the commands that were sent."""
    if ack.stage in _BY_ANOTHER:
        return _ended_by_another(ack, kinds)
    return ack.reason or ("" if ack.stage is Stage.COMPLETED else ack.stage.value)


def _ended_by_another(ack: Ack, kinds: Mapping[int, CommandKind]) -> str:
    """Return which command, or what else, ended a command; with the kind of each that is known."""
    text = f"{ack.stage} {ack.reason}".rstrip()
    named = _COMMAND.search(ack.reason)
    kind = kinds.get(int(named[1])) if named else None
    if named is None or kind is None:
        return text
    if ack.stage is not Stage.SUPERSEDED:
        return f"{text} ({kind})"
    replaced = "the plan" if kinds.get(ack.command_id) is CommandKind.UPLOAD_PLAN else f"command {ack.command_id}"
    return f"command {named[1]} ({kind}) replaced {replaced}"
