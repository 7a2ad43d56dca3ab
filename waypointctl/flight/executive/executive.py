"""The executive on board: it executes commands and follows the plan; its modes are in state_machine.py.

docs/executive.md shows the machine, docs/commands.md what each command does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.command_life import FLIGHT_ENDED
from waypointctl.flight.executive.command_tracker import CommandTracker
from waypointctl.flight.executive.commands import end_command, names_of
from waypointctl.flight.executive.monitors import FenceMonitor, LinkMonitor, update_leg
from waypointctl.flight.executive.plan_execution import PlanExecution
from waypointctl.flight.executive.rules import FALL, OBSERVATION_NS, Rules
from waypointctl.flight.executive.start import decide, start
from waypointctl.flight.executive.state_machine import BUSY, POLICY_MODES, TRANSITIONS, Signal
from waypointctl.log.messages import (
    Command,
    CommandStage,
    CommandStatus,
    Event,
    EventKind,
    Mode,
    PlannedWaypoint,
    Severity,
    Stage,
)

FloatArray = NDArray[np.float64]

_NO_GOALS: Final = np.zeros((1, 2, 2))


class Executive:
    """The state machine on board. It reports through callables and knows nothing of the link."""

    def __init__(
        self,
        report: Callable[[CommandStage], None],
        announce: Callable[[Event], None],
        *,
        remind: Callable[[CommandStage], None] = lambda _: None,
        rules: Rules | None = None,
    ) -> None:
        """Stand idle.

        Args:
            report: takes each stage of a command at its moment.
            announce: takes every event.
            remind: takes the stage that a command is in when it arrives once more.
            rules: what the robot does by itself; without them it only aborts a plan when a leg fails.
        """
        self._announce = announce
        self._tracker = CommandTracker(report, remind)
        self._execution = PlanExecution(rules or Rules(), self._tracker, announce)
        self._link = LinkMonitor()
        self._fence = FenceMonitor()

    @property
    def mode(self) -> Mode:
        """What it is doing."""
        return self._execution.mode

    @property
    def policy_active(self) -> bool:
        """Whether the policy has the motors."""
        return self.mode in POLICY_MODES

    @property
    def reached(self) -> tuple[int, ...]:
        """The waypoints reached so far: indices in the mission, each once, in order."""
        return self._execution.reached

    @property
    def goals(self) -> FloatArray:
        """The current waypoint and the next, (1, 2, 2) [m]; zeros while there is none."""
        leg = self._execution.leg
        return _NO_GOALS if leg is None else leg.goals

    @property
    def target(self) -> PlannedWaypoint | None:
        """The waypoint it drives to, holds at, or resumes after a pause."""
        leg = self._execution.leg
        return None if leg is None else leg.waypoint

    def on_contact(self, now_ns: int) -> None:
        """Record that a heartbeat or a command has arrived from the ground."""
        self._link.on_contact(self._execution, now_ns)

    def on_action(self, now_ns: int) -> None:
        """Record that an action has arrived from the ground; it is applied if nothing is under way on board."""
        self.on_contact(now_ns)
        if (self.mode, Signal.TELEOPERATE) in TRANSITIONS:
            self._execution.clear()  # teleoperation ends the plan
            self._execution.machine.signal(Signal.TELEOPERATE)
            self._execution.emit(now_ns, EventKind.TELEOPERATION_STARTED, "teleoperation started")

    def execute(self, now_ns: int, command: Command) -> None:
        """Take a command that has arrived. Each id is executed once."""
        self.on_contact(now_ns)
        tracker = self._tracker
        if tracker.knows(command.id):
            tracker.repeat(now_ns, command)
            return
        self._end_expired(now_ns)
        self._start_due(now_ns)  # what has waited until now comes before what arrives now
        tracker.receive(now_ns, command)
        self._execution.ordering.receive(command.id)
        text = f"command {command.id} received: {command.kind} {names_of(command)}".rstrip()
        self._execution.emit(now_ns, EventKind.COMMAND_RECEIVED, text, command_id=command.id)
        decide(self._execution, now_ns, command)

    def sense(self, now_ns: int, position: FloatArray, fell: bool, heading_rad: float) -> None:
        """Look at the world and the clock.

        Args:
            now_ns: the time.
            position: where the robot is, (1, >= 2) [m].
            fell: whether it has fallen.
            heading_rad: where it looks.
        """
        if self.mode is Mode.FALLEN:
            return
        if fell:
            self._fall(now_ns)
            return
        self._end_expired(now_ns)
        self._link.check(self._execution, now_ns)
        self._start_due(now_ns)
        self._fence.check(self._execution, now_ns, float(position[0, 0]), float(position[0, 1]))
        update_leg(self._execution, now_ns, position, heading_rad)

    def _end_expired(self, now_ns: int) -> None:
        """End the commands whose time is over."""
        for command_id in self._tracker.expired(now_ns):
            begun = self._tracker.has_started(command_id)
            reason = "not completed in time" if begun else "not started in time"
            end_command(self._execution, now_ns, command_id, Stage.EXPIRED, reason)

    def _start_due(self, now_ns: int) -> None:
        """Start the commands that have waited for their time, unless the link keeps them waiting."""
        while (
            not self._link.blocks_commands(self._execution) and (command := self._tracker.take_due(now_ns)) is not None
        ):
            start(self._execution, now_ns, command)

    @property
    def plans(self) -> bool:
        """Whether it does something by itself, now or later, provided that the link does not get worse."""
        pending = self._tracker.pending and not self._link.blocks_commands(self._execution)
        return bool(pending) or self.mode in BUSY or self._tracker.next_expiry_ns is not None

    @property
    def waits_for_ground(self) -> bool:
        """Whether it resumes with the next message from the ground: it holds because of a link loss."""
        return self._link.lost and (bool(self._tracker.pending) or self._link.resumes_on_contact(self._execution))

    @property
    def gives_up_ns(self) -> int | None:
        """Until when a message has to arrive before it aborts what it holds and returns home [ns]; None: never."""
        execution = self._execution
        goes_home = (
            execution.rules.on_link_loss == "return_home" and execution.home_id is None and bool(execution.under_way)
        )
        return self._link.deadline_ns(execution) if goes_home else None

    @property
    def cause(self) -> str:
        """The rule or command because of which it is stopped or returning home."""
        return self._execution.cause

    @property
    def statuses(self) -> tuple[CommandStatus, ...]:
        """The command statuses in a frame of telemetry."""
        return self._tracker.statuses

    def release(self) -> None:
        """Stand: the ground, which had the motors, is gone."""
        self._execution.stand_idle()

    def close(self, now_ns: int) -> None:
        """End every command that is still open, for the flight is over."""
        for command_id in self._tracker.open_ids:
            self._tracker.advance(now_ns, command_id, Stage.CANCELLED, FLIGHT_ENDED)

    def next_ns(self, now_ns: int) -> int | None:
        """Return when the next action is due by itself while the robot is stopped; None if none is.

        At that time the executive has to be updated, not before `now_ns`; a moving robot is always updated.
        """
        if self.policy_active or self.mode is Mode.TELEOPERATED:
            return now_ns
        execution, tracker = self._execution, self._tracker
        due = [self._link.deadline_ns(execution), tracker.next_expiry_ns]
        if tracker.pending and not self._link.blocks_commands(execution):
            due.append(tracker.pending[0].not_before_ns)
        if self.mode is Mode.HOLDING and (target := self.target) is not None:
            due.append(execution.stood_ns + target.hold_ns)
        if self.mode is Mode.OBSERVING:
            due.append(execution.stood_ns + OBSERVATION_NS)
        times = [time_ns for time_ns in due if time_ns is not None]
        return max(now_ns, min(times)) if times and self.mode is not Mode.FALLEN else None

    def state(self) -> dict[str, object]:
        """Return all that a replay needs to continue from here, as plain data."""
        watches = {"link": asdict(self._link), "fence": asdict(self._fence)}
        # While every command has come in its turn, the sequence follows from the commands themselves.
        ordering = {} if self._execution.ordering.kept else {"sequence": self._execution.ordering.state()}
        return {**self._execution.state(), "commands": self._tracker.state(), **watches, **ordering}

    def _fall(self, now_ns: int) -> None:
        execution = self._execution
        execution.machine.signal(Signal.FALL)
        execution.emit(now_ns, EventKind.FALL, "the robot has fallen", severity=Severity.ERROR)
        execution.fail_all(now_ns, FALL)
        for command_id in self._tracker.open_ids:
            self._tracker.advance(now_ns, command_id, Stage.CANCELLED, FALL)
