"""What the operator knows: only what has arrived."""

from __future__ import annotations

from dataclasses import dataclass, field

from waypointctl.flight.executive.rules import AT_HOME
from waypointctl.log.messages import FINAL_STAGES, Ack, Mode, Stage, Telemetry


@dataclass(slots=True)
class OperatorView:
    """The operator's picture of the robot.

    Attributes:
        telemetry: the newest frame that has arrived; None before the first.
        stages: of each command sent, the last stage heard of.
        reasons: why a command failed or was rejected.
        went_home: whether the robot has told of a way home.
        ended_ns: when, on the robot's clock, the command ended of whose end was heard last; -1 before the first.
    """

    telemetry: Telemetry | None = None
    stages: dict[int, Stage] = field(default_factory=dict)
    reasons: dict[int, str] = field(default_factory=dict)
    went_home: bool = False
    ended_ns: int = -1
    _reached: set[int] = field(default_factory=set)

    @property
    def reached(self) -> tuple[int, ...]:
        """The waypoints that the robot has reported as reached."""
        return self.telemetry.reached if self.telemetry else ()

    def knows_reached(self, index: int) -> bool:
        """Tell whether the robot has reported a waypoint as reached."""
        return index in self._reached

    @property
    def is_current(self) -> bool:
        """Whether a frame has arrived that is no older than the last end heard of: the one before it may be lost."""
        return self.ended_ns < 0 or (self.telemetry is not None and self.telemetry.issued_ns >= self.ended_ns)

    def on_message(self, message: Ack | Telemetry) -> None:
        """Take what has arrived."""
        if isinstance(message, Telemetry):
            if self.telemetry is None or message.frame >= self.telemetry.frame:  # one that was overtaken is no news
                self.telemetry = message
                self._reached.update(message.reached[len(self._reached) :])  # what is reached stays so, in its order
            self.went_home = self.went_home or message.mode is Mode.RETURNING or message.cause.startswith(AT_HOME)
            return
        if self.stages.get(message.command_id) in FINAL_STAGES:
            return
        self.stages[message.command_id] = message.stage
        if message.stage in FINAL_STAGES:
            self.ended_ns = max(self.ended_ns, message.issued_ns)
        if message.reason:
            self.reasons[message.command_id] = message.reason
