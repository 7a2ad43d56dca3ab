"""The ground as a whole: who decides, what was decided before the flight, and what carries it to the link."""

from __future__ import annotations

from collections.abc import Iterable

from waypointctl.flight.belief import Belief
from waypointctl.flight.executive.rules import FALL
from waypointctl.flight.link.frames import BodyFrame
from waypointctl.flight.operator.agenda import Agenda
from waypointctl.flight.operator.dispatcher import Dispatcher
from waypointctl.flight.operator.operator import Operator
from waypointctl.flight.operator.order import Order
from waypointctl.flight.operator.pilot import Pilot
from waypointctl.flight.operator.pulse import Pulse
from waypointctl.log.messages import FINAL_STAGES, Ack, GroundControl, Telemetry


class Station:
    """The operator, the schedule and the dispatcher, in the order of their times.

    Attributes:
        console_is_open: whether a person may still send something.
    """

    def __init__(self, operator: Operator, schedule: Agenda[Order], dispatcher: Dispatcher, pulse: Pulse) -> None:
        """Put the ground together."""
        self.operator = operator
        self.dispatcher = dispatcher
        self.console_is_open = False
        self._schedule = schedule
        self._pulse = pulse
        self._concluded: set[int] = set()  # commands whose end has been heard of

    @property
    def belief(self) -> Belief:
        """What the ground knows of the robot."""
        return self.operator.belief

    @property
    def reached(self) -> tuple[int, ...]:
        """The waypoints that it knows to be reached: their indices in the mission."""
        return self.operator.reached

    @property
    def verdict(self) -> str:
        """Why the operator ended the mission, where that is a failure."""
        return self.operator.verdict

    @property
    def finished(self) -> bool:
        """Whether nothing is left to send or to hear of; after a fall nothing is.

        A person at the console may try again where the script has given up, but nobody can make a fallen robot walk.
        """
        if not self.operator.finished or (self.console_is_open and self.verdict != FALL):
            return False
        if self.verdict == FALL:
            return True
        return self._schedule.next_ns is None and not self.dispatcher.awaits and self.belief.is_whole

    @property
    def plans_nothing(self) -> bool:
        """Whether it wants to send nothing more by itself, but for signs of life."""
        return self._schedule.next_ns is None and self.operator.wake_ns is None and self.dispatcher.wake_ns is None

    @property
    def acts_on_states(self) -> bool:
        """Whether every state of the robot that arrives may make it send something."""
        return self.operator.acts_on_states

    @property
    def next_beat_ns(self) -> int | None:
        """When it sends the next sign of life [ns]; None for never."""
        return self._pulse.next_ns

    @property
    def missing(self) -> str:
        """What has not been heard of the operator's commands, in words; empty where nothing is missing."""
        missing = (self.dispatcher.missing(command_id) for command_id in reversed(self.operator.newest))
        return next(filter(None, missing), "")

    @property
    def wake_ns(self) -> int | None:
        """When the ground wants to act next, if nothing arrives before [ns]; None for never."""
        earliest = self._schedule.next_ns
        for time_ns in (self.operator.wake_ns, self.dispatcher.wake_ns, self._pulse.next_ns):
            if time_ns is not None and (earliest is None or time_ns < earliest):
                earliest = time_ns
        return earliest

    def begin(self) -> None:
        """Send what is sent at mission start."""
        self.issue(0, self.operator.begin(), own=True)

    def hear(self, now_ns: int, message: Ack | Telemetry) -> None:
        """Take what has arrived, and do what follows from it."""
        self.dispatcher.hear(now_ns, message)
        if isinstance(message, Ack) and message.stage in FINAL_STAGES:
            self._conclude(now_ns, message)
        else:
            self.issue(now_ns, self.operator.hear(now_ns, message), own=True)

    def _conclude(self, now_ns: int, end: Ack) -> None:
        """Let the operator hear of a command's end, once: the link may double it, and it may be asked for once more."""
        if end.command_id not in self._concluded:
            self._concluded.add(end.command_id)
            self.issue(now_ns, self.operator.hear(now_ns, end), own=True)

    def see(self, now_ns: int, frame: BodyFrame) -> GroundControl | None:
        """Take a state of the body that has arrived; return the action that answers it, where a pilot flies."""
        if not isinstance(self.operator, Pilot):
            return None
        control, orders = self.operator.see(now_ns, frame)
        self.issue(now_ns, orders, own=True)
        return control

    def wake(self, now_ns: int) -> None:
        """Do what is due now."""
        self._pulse.beat(now_ns)
        self.issue(now_ns, self._schedule.due(now_ns))
        self.issue(now_ns, [] if self.operator.finished else self.operator.wake(now_ns), own=True)
        for end in self.dispatcher.wake(now_ns):
            self._conclude(now_ns, end)

    def issue(self, now_ns: int, orders: Iterable[Order], *, own: bool = False) -> None:
        """Send orders; the operator is told the ids of its own."""
        for order in orders:
            command_id = self.dispatcher.issue(now_ns, order)
            self.operator.note_kind(command_id, order.kind)
            if own:
                self.operator.issued(command_id, order)
            elif not self.operator.finished:
                self.issue(now_ns, self.operator.interfered(now_ns, order), own=True)

    def state(self) -> dict[str, object]:
        """Return what the ground does next depends on, as plain data."""
        scheduled = [[at_ns, order.words] for at_ns, order in self._schedule.entries()]
        return {
            "operator": self.operator.state(),
            "commands": dict(self.dispatcher.state()),
            "scheduled": scheduled,
            "heartbeats": self._pulse.beats,
        }
