"""The ground as a whole: who decides, what was decided before the flight, and what carries it to the link."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from waypointctl.flight.executive.rules import FALL
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import BodyFrame, Heartbeat, LoggedDirection
from waypointctl.flight.operator.dispatcher import Dispatcher, Uplink
from waypointctl.flight.operator.joint import JointOperator
from waypointctl.flight.operator.operator import Operator
from waypointctl.flight.operator.planner import MissionOperator, ShortRangeGoalOperator, WaypointOperator
from waypointctl.flight.operator.requests import CommandRequest, EventQueue, scheduled_requests
from waypointctl.flight.operator.timing import ACK_BYTES, LegClock, RetryPolicy, answer_time, leaving_time, patience_ns
from waypointctl.flight.sink import Sink
from waypointctl.log.messages import FINAL_STAGES, Ack, GroundControl, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.units import ns


@dataclass(slots=True)
class HeartbeatSender:
    """Beats at a period."""

    uplink: Uplink  # takes a heartbeat on its way
    period_ns: int  # between two of them; 0 for none
    next_ns: int | None = field(init=False)  # when the next is due; None for never
    beats: int = 0  # number of heartbeats sent

    def __post_init__(self) -> None:
        """Begin a period after mission start, when something else is sent."""
        self.next_ns = self.period_ns or None

    def send_due(self, now_ns: int) -> None:
        """Send the heartbeat that is due, if one is."""
        if self.next_ns is None or self.next_ns > now_ns:
            return
        number = self.beats
        self.uplink(now_ns, lambda arrives_ns: Heartbeat(number, now_ns, arrives_ns))
        self.beats += 1
        self.next_ns += self.period_ns


class Station:
    """The operator, the schedule and the dispatcher, in the order of their times.

    Attributes:
        operator: who decides.
        dispatcher: what sends it.
        heartbeats: signs of life that it sends.
        console_is_open: whether a person may still send something.
    """

    def __init__(
        self,
        operator: Operator,
        schedule: EventQueue[CommandRequest],
        dispatcher: Dispatcher,
        heartbeats: HeartbeatSender,
        arrival_ns: Callable[[int], int | None],
    ) -> None:
        """Put the ground together; `arrival_ns` is when what is sent at a time [ns] arrives at the latest [ns]."""
        self.operator = operator
        self.dispatcher = dispatcher
        self.console_is_open = False
        self._schedule = schedule
        self._arrival_ns = arrival_ns
        self.heartbeats = heartbeats
        self._on_final: set[int] = set()  # commands whose end is known

    @property
    def finished(self) -> bool:
        """Whether nothing is left to send or to receive; after a fall nothing is.

        A person at the console may try again where the script has stopped, but no command moves a fallen robot.
        """
        operator = self.operator
        if not operator.finished or (self.console_is_open and operator.failure != FALL):
            return False
        if operator.failure == FALL:
            return True
        return self._schedule.next_ns is None and not self.dispatcher.awaits and operator.reported.is_current

    @property
    def is_idle(self) -> bool:
        """Whether it wants to send nothing more by itself, but for signs of life."""
        return self._schedule.next_ns is None and self.operator.wake_ns is None and self.dispatcher.wake_ns is None

    @property
    def missing(self) -> str:
        """Which reports of the operator's commands are missing, in words; empty where none is."""
        missing = (self.dispatcher.missing(command_id) for command_id in reversed(self.operator.newest))
        return next(filter(None, missing), "")

    @property
    def wake_ns(self) -> int | None:
        """When the ground wants to act next, if nothing arrives before [ns]; None for never."""
        earliest = self._schedule.next_ns
        for time_ns in (self.operator.wake_ns, self.dispatcher.wake_ns, self.heartbeats.next_ns):
            if time_ns is not None and (earliest is None or time_ns < earliest):
                earliest = time_ns
        return earliest

    def begin(self) -> None:
        """Send what is sent at mission start."""
        self.issue(0, self.operator.begin(), own=True)

    def on_message(self, now_ns: int, message: Ack | Telemetry) -> None:
        """Take what has arrived, and do what follows from it."""
        self.operator.yield_to_return(now_ns, self._arrival_ns)
        self.dispatcher.on_message(now_ns, message)
        if isinstance(message, Ack) and message.stage in FINAL_STAGES:
            self._conclude(now_ns, message)
        else:
            self.issue(now_ns, self.operator.on_message(now_ns, message), own=True)

    def _conclude(self, now_ns: int, end: Ack) -> None:
        """Report a command's end to the operator once: the link may duplicate it, and it may be requested again."""
        if end.command_id not in self._on_final:
            self._on_final.add(end.command_id)
            self.issue(now_ns, self.operator.on_message(now_ns, end), own=True)

    def on_state(self, now_ns: int, frame: BodyFrame) -> GroundControl | None:
        """Take a state of the body that has arrived; return the action that answers it, where a pilot flies."""
        if not isinstance(self.operator, JointOperator):
            return None
        self.operator.yield_to_return(now_ns, self._arrival_ns)
        control, requests = self.operator.on_state(now_ns, frame)
        self.issue(now_ns, requests, own=True)
        return control

    def wake(self, now_ns: int) -> None:
        """Do what is due now."""
        self.operator.yield_to_return(now_ns, self._arrival_ns)
        self.heartbeats.send_due(now_ns)
        self.issue(now_ns, self._schedule.due(now_ns))
        self.issue(now_ns, [] if self.operator.finished else self.operator.wake(now_ns), own=True)
        for end in self.dispatcher.wake(now_ns):
            self._conclude(now_ns, end)

    def issue(self, now_ns: int, requests: Iterable[CommandRequest], *, own: bool = False) -> None:
        """Send orders; the operator gets the ids of its own."""
        for request in requests:
            command_id = self.dispatcher.issue(now_ns, request)
            self.operator.note_kind(command_id, request.kind)
            if own:
                self.operator.on_issued(command_id, request)
            elif not self.operator.finished:
                self.issue(now_ns, self.operator.on_external_request(now_ns, request), own=True)

    def state(self) -> dict[str, object]:
        """Return what the ground does next depends on, as plain data."""
        scheduled = [[at_ns, request.words] for at_ns, request in self._schedule.entries()]
        return {
            "operator": self.operator.state(),
            "commands": dict(self.dispatcher.state()),
            "scheduled": scheduled,
            "heartbeats": self.heartbeats.beats,
        }


def station_for(
    mission: Mission,
    joint: Callable[[], JointOperator],
    sink: Sink,
    uplink: LoggedDirection[Any],
    down: Direction[Any],
    robot_ns: int,
) -> Station:
    """Return the ground at mission start.

    Args:
        mission: the mission.
        joint: makes the operator that drives the robot from the ground, for autonomy `joint`.
        sink: takes the ground's own records.
        uplink: the direction of commands and heartbeats.
        down: the direction of acknowledgements.
        robot_ns: how long the robot takes to answer at most [ns].
    """
    commands, margin_ns = mission.commands, ns(mission.commands.margin_s)
    answer_by = answer_time(uplink.direction, down, robot_ns, margin_ns)
    retry_policy = RetryPolicy(commands.acknowledged, commands.retries, answer_by, patience_ns(down, margin_ns))
    operator: Operator
    if mission.autonomy == "joint":
        operator = joint()
    elif mission.autonomy == "short_range_goal":
        operator = ShortRangeGoalOperator(mission, LegClock(answer_by, leaving_time(uplink.direction)), sink)
    else:
        operator = MissionOperator(mission, sink) if mission.autonomy == "mission" else WaypointOperator(mission, sink)
    heartbeats = HeartbeatSender(uplink.send, ns(mission.operator.heartbeat_s or 0.0))
    dispatcher = Dispatcher(uplink.send, retry_policy, sink)
    arrival_ns = partial(uplink.direction.latest_arrival_ns, size_bytes=ACK_BYTES)
    return Station(operator, scheduled_requests(mission), dispatcher, heartbeats, arrival_ns)
