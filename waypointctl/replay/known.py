"""What the ground knows of a flight under way, in the form of its story: nothing that has not been heard."""

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
from waypointctl.replay.chronicle import Chronicle


class KnownFlight:
    """A sink that keeps what has arrived at the ground, or happened there.

    Attributes:
        chronicle: what is known; a waypoint counts as reached from when telemetry says so.
        now_ns: the time on the operator's clock that was last told.
    """

    def __init__(self, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting) -> None:
        """Begin with the waypoints of the mission, and what else it has fixed beforehand."""
        self.chronicle = Chronicle(waypoints, setting)
        self.now_ns = 0
        self._reached: set[int] = set()

    def __call__(self, message: Message) -> None:
        """Take one message; what happens on board or on the link is not listened to."""
        match message:
            case Telemetry():
                self.chronicle(message)
                for index in message.reached:
                    self._reach(index, message)
            case Ack() | Event(clock=Clock.OPERATOR) | CommandStage(clock=Clock.OPERATOR):
                self.chronicle(message)
        self.pass_time(self.chronicle.now_ns)

    def pass_time(self, now_ns: int) -> None:
        """Take the time that it is on the operator's clock."""
        self.now_ns = self.chronicle.now_ns = max(self.now_ns, now_ns)

    def _reach(self, index: int, frame: Telemetry) -> None:
        if index not in self._reached:
            self._reached.add(index)
            text = f"waypoint {index + 1} reached"
            self.chronicle(
                Event(frame.issued_ns, EventKind.WAYPOINT_REACHED, Clock.OPERATOR, Severity.INFO, text, index)
            )
