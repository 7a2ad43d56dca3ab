"""Telemetry of the robot: frames at a rate, acknowledgements, and every state under teleoperation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from waypointctl.flight.executive.executive import Executive
from waypointctl.flight.link.frames import BodyFrame, LoggedDirection
from waypointctl.log.messages import Ack, CommandStage, CommandStatus, Mode, Telemetry
from waypointctl.sim.stepping import SingleRobot
from waypointctl.task.view import Body

_Standing: TypeAlias = tuple[Mode, int, int, tuple[CommandStatus, ...], str]


@dataclass(slots=True)
class TelemetryChanges:
    """Keeps the number of the first frame with the content of the newest frame sent, apart from the pose."""

    first: int = 0  # the number of that frame
    newest: int = -1  # the number of the newest frame
    _standing: _Standing | None = None

    def sent(self, frame: Telemetry) -> None:
        """Record a frame that is sent; `first` changes with its content."""
        self.newest = frame.frame
        standing = frame.mode, frame.target, len(frame.reached), frame.commands, frame.cause
        if standing != self._standing:
            self.first, self._standing = frame.frame, standing

    def unreported(self, executive: Executive) -> bool:
        """Return whether no frame has reported the current state yet."""
        target = -1 if executive.target is None else executive.target.index
        reached = len(executive.reached)
        return self._standing != (executive.mode, target, reached, executive.statuses, executive.cause)

    def reported_in(self, frame: Telemetry | None) -> bool:
        """Return whether a frame that has arrived reports the current state; None for no frame yet."""
        return frame is not None and frame.frame >= self.first


Downlink: TypeAlias = LoggedDirection[Ack | Telemetry | BodyFrame]


class Reporter:
    """Sends telemetry and acknowledgements.

    Attributes:
        next_ns: when the next frame is due [ns].
        frames: how many have been sent.
        changes: which frame was the first with the robot's current state.
    """

    def __init__(self, downlink: Downlink, period_ns: int, beacon_ns: int, *, every_state: bool) -> None:
        """Report every `period_ns`, at rest every `beacon_ns`; with `every_state` each control step's state too."""
        self.next_ns = 0
        self.frames = 0
        self.changes = TelemetryChanges()
        self._downlink = downlink
        self._period_ns = period_ns
        self._beacon_ns = max(beacon_ns, period_ns)
        self.every_state = every_state

    def frame_if_due(self, now_ns: int, executive: Executive, body: Body) -> bool:
        """Send a frame at the telemetry rate; return whether one was due."""
        if now_ns < self.next_ns:
            return False
        self.next_ns += ((now_ns - self.next_ns) // self._period_ns + 1) * self._period_ns
        self.frame(now_ns, executive, body)
        return True

    def put_off(self, now_ns: int) -> None:
        """Let the next frame wait until the beacon is due: the robot rests."""
        periods = -(-self._beacon_ns // self._period_ns)
        self.next_ns = max(self.next_ns, now_ns - now_ns % self._period_ns + periods * self._period_ns)

    def resume(self, now_ns: int) -> None:
        """Report at the usual rate again."""
        self.next_ns = -(-now_ns // self._period_ns) * self._period_ns

    def frame(self, now_ns: int, executive: Executive, body: Body) -> None:
        """Send a frame of telemetry."""
        target, velocity = executive.target, body.velocity[0]
        frame = Telemetry(
            frame=self.frames,
            mode=executive.mode,
            x_m=float(body.position[0, 0]),
            y_m=float(body.position[0, 1]),
            z_m=float(body.position[0, 2]),
            heading_rad=float(body.yaw[0]),
            speed_mps=float(np.hypot(velocity[0], velocity[1])),
            target=-1 if target is None else target.index,
            reached=executive.reached,
            issued_ns=now_ns,
            received_ns=now_ns,
            commands=executive.statuses,
            cause=executive.cause,
        )
        self.frames += 1
        self.changes.sent(frame)
        self._downlink.send(now_ns, lambda arrives_ns: replace(frame, received_ns=arrives_ns))

    def acknowledge(self, it: CommandStage) -> None:
        """Tell the ground which stage a command has come to."""
        now_ns = it.time_ns
        self._downlink.send(now_ns, lambda arrives_ns: Ack(it.command_id, it.stage, it.reason, now_ns, arrives_ns))

    def state(self, now_ns: int, step: int, plant: SingleRobot) -> None:
        """Send the state of the body, where every state is reported."""
        if not self.every_state:
            return
        qpos, qvel = plant.qpos[0].copy(), plant.qvel[0].copy()
        self._downlink.send(now_ns, lambda arrives_ns: BodyFrame(step, qpos, qvel, now_ns, arrives_ns))
