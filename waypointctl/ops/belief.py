"""What the operator knows: only what has arrived."""

from __future__ import annotations

from dataclasses import dataclass, field

from waypointctl.log.messages import Ack, Stage, Telemetry


@dataclass(slots=True)
class Belief:
    """The operator's picture of the robot.

    Attributes:
        telemetry: the newest frame that has arrived; None before the first.
        stages: of each command sent, the last stage heard of.
        reasons: why a command failed or was rejected.
    """

    telemetry: Telemetry | None = None
    stages: dict[int, Stage] = field(default_factory=dict)
    reasons: dict[int, str] = field(default_factory=dict)

    @property
    def reached(self) -> tuple[int, ...]:
        """The waypoints that the robot has reported as reached."""
        return self.telemetry.reached if self.telemetry else ()

    def hear(self, message: Ack | Telemetry) -> None:
        """Take what has arrived."""
        if isinstance(message, Telemetry):
            self.telemetry = message
            return
        self.stages[message.command_id] = message.stage
        if message.reason:
            self.reasons[message.command_id] = message.reason
