"""The operator's view of a flight under way: what has arrived on the ground, or happened there, and nothing else."""

from __future__ import annotations

from collections.abc import Iterable

from waypointctl.log.messages import (
    Ack,
    Clock,
    CommandStage,
    Event,
    EventKind,
    Message,
    PlannedWaypoint,
    Severity,
    Telemetry,
)
from waypointctl.log.setting import MissionSetting
from waypointctl.replay.summary_builder import FlightSummaryBuilder


class OperatorView:
    """A sink that keeps of a flight what the operator knows.

    Attributes:
        flight: what is known; a waypoint counts as reached from when telemetry reports it.
        now_ns: the latest time on the operator's clock.
    """

    def __init__(self, waypoints: Iterable[PlannedWaypoint] = (), setting: MissionSetting | None = None) -> None:
        """Begin with the waypoints of the mission, and what else it has fixed beforehand."""
        self.flight = FlightSummaryBuilder(waypoints, setting or MissionSetting())
        self.now_ns = 0
        self._reached: set[int] = set()

    def __call__(self, message: Message) -> None:
        """Take one message; what happens on board or on the link is left out."""
        match message:
            case Telemetry():
                self.flight(message)
                for index in message.reached:
                    self._reach(index, message)
            case Ack() | Event(clock=Clock.OPERATOR) | CommandStage(clock=Clock.OPERATOR):
                self.flight(message)
        self.pass_time(self.flight.now_ns)

    def pass_time(self, now_ns: int) -> None:
        """Take the time that it is on the operator's clock."""
        self.now_ns = self.flight.now_ns = max(self.now_ns, now_ns)

    def _reach(self, index: int, frame: Telemetry) -> None:
        if index not in self._reached:
            self._reached.add(index)
            text = f"waypoint {index + 1} reached"
            self.flight(Event(frame.issued_ns, EventKind.WAYPOINT_REACHED, Clock.OPERATOR, Severity.INFO, text, index))
