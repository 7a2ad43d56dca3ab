"""The robot's state as the operator knows it: from what has arrived, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass, field

from waypointctl.flight.executive.rules import AT_HOME
from waypointctl.log.messages import FINAL_STAGES, Ack, Mode, Telemetry


@dataclass(slots=True)
class ReportedState:
    """What the robot has reported.

    Attributes:
        telemetry: the newest frame that has arrived; None before the first.
        went_home: whether a way home has been reported.
        ended_ns: when, on the robot's clock, the command ended whose end was reported last; -1 before the first.
    """

    telemetry: Telemetry | None = None
    went_home: bool = False
    ended_ns: int = -1
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
