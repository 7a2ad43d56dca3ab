"""What the operator has heard, for whoever asks at the console: nothing that has not arrived."""

from __future__ import annotations

import math
from dataclasses import dataclass

from waypointctl.display_text import printable
from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Clock,
    CommandStage,
    CommandStatus,
    Event,
    EventKind,
    Message,
    Stage,
    Telemetry,
)
from waypointctl.units import seconds


@dataclass(slots=True)
class _Sent:
    what: str
    issued_ns: int
    stage: Stage | None = None
    reason: str = ""
    told_ns: int = 0  # on the clock of whoever came to that stage


class Heard:
    """A sink that keeps what the ground knows."""

    def __init__(self) -> None:
        """Know nothing."""
        self._frame: Telemetry | None = None
        self._sent: dict[int, _Sent] = {}

    def __call__(self, message: Message) -> None:
        """Take one message; what happens on board or on the link is not listened to."""
        match message:
            case Telemetry():
                if self._frame is None or message.issued_ns >= self._frame.issued_ns:
                    self._frame = message
                for it in message.commands:
                    self._learn(it, message.issued_ns)
            case Event(kind=EventKind.COMMAND_SENT):
                what = printable(message.text.partition(": ")[2])
                self._sent.setdefault(message.command_id, _Sent(what, message.time_ns))
            case CommandStage(clock=Clock.OPERATOR):
                self._reach(message.command_id, message.stage, message.reason, message.time_ns)
            case Ack():
                self._reach(message.command_id, message.stage, message.reason, message.issued_ns)

    def _learn(self, it: CommandStatus, issued_ns: int) -> None:
        """Take what a frame of telemetry tells of a command, unless an acknowledgement of its end has come."""
        sent = self._sent.get(it.command_id)
        if sent is not None and sent.stage not in FINAL_STAGES and issued_ns > sent.told_ns and it.stage != sent.stage:
            self._reach(it.command_id, it.stage, it.reason, issued_ns)

    def status(self, now_ns: int) -> list[str]:
        """Return what is known at a time on the operator's clock [ns], a line each."""
        return [*self._robot(now_ns), *(self._command(command_id, now_ns) for command_id in self._sent)]

    def rows(self, now_ns: int, most: int) -> list[tuple[str, str, str, str]]:
        """Return of each of the newest commands: its id, what it is, the stage known of, and how long ago that was."""
        rows = []
        for command_id, sent in list(self._sent.items())[-most:]:
            stage, since_ns = ("no word yet", sent.issued_ns) if sent.stage is None else (str(sent.stage), sent.told_ns)
            reason = f" ({sent.reason})" if sent.reason else ""
            ago_s = max(0.0, seconds(now_ns - since_ns))
            rows.append((str(command_id), sent.what, f"{stage}{reason}", f"{ago_s:.1f} s"))
        return rows

    def _reach(self, command_id: int, stage: Stage, reason: str, time_ns: int) -> None:
        sent = self._sent.get(command_id)
        if sent is not None:
            sent.stage, sent.reason, sent.told_ns = stage, printable(reason), time_ns

    def _robot(self, now_ns: int) -> list[str]:
        frame = self._frame
        if frame is None:
            return ["robot: nothing heard yet"]
        age_s = seconds(now_ns - frame.issued_ns)
        target = "" if frame.target < 0 else f" (waypoint {frame.target + 1})"
        reached = ", ".join(str(index + 1) for index in frame.reached) or "none"
        heading_deg = round(math.degrees(frame.heading_rad))  # a whole number has no -0
        return [
            f"robot, {age_s:.2f} s ago: at ({frame.x_m:.2f}, {frame.y_m:.2f}) m, heading {heading_deg} deg, "
            f"{frame.speed_mps:.2f} m/s, {frame.mode}{target}; waypoints reached: {reached}"
        ]

    def _command(self, command_id: int, now_ns: int) -> str:
        sent = self._sent[command_id]
        reason = f" ({sent.reason})" if sent.reason else ""
        stage = (
            "no word yet" if sent.stage is None else f"{sent.stage}{reason} {seconds(now_ns - sent.told_ns):.2f} s ago"
        )
        return f"command {command_id} {sent.what}: {stage}"
