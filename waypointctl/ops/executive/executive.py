"""The executive on board: what becomes of a command, waypoint by waypoint.

    IDLE --command--> WALKING --last waypoint--> DONE
                      |     ^
              reached |     | hold over
                      v     |
                      HOLDING
    WALKING --time-out, on_failure abort--> FAILED      any --fall--> FALLEN

A command that is accepted replaces the plan, from every mode but FALLEN.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.messages import Clock, Command, Event, EventKind, Mode, PlannedWaypoint, Severity, Stage
from waypointctl.task.acceptance import Acceptance, reached
from waypointctl.units import seconds

FloatArray = NDArray[np.float64]

# Why a command was rejected or failed, as acknowledgements say it.
TIMEOUT: Final = "timeout"
FALL: Final = "fall"


@dataclass(slots=True)
class Executive:
    """The state machine on board. It reports through two callables and knows nothing of the link.

    Attributes:
        report: told (now, command id, stage, reason) when a command's stage changes.
        announce: told every event.
    """

    report: Callable[[int, int, Stage, str], None]
    announce: Callable[[Event], None]
    mode: Mode = Mode.IDLE
    command_id: int = -1
    plan: tuple[PlannedWaypoint, ...] = ()
    on_failure: str = "abort"
    leg: int = 0  # which waypoint of the plan
    since_ns: int = 0  # when this leg, or this hold, began
    reached: list[int] = field(default_factory=list)  # indices in the mission
    obeyed: set[int] = field(default_factory=set)  # ids of commands, each obeyed once
    goals: FloatArray = field(default_factory=lambda: np.zeros((1, 2, 2)))  # this leg's waypoint and the next [m]
    _acceptance: Acceptance = field(default_factory=Acceptance)  # this leg's

    @property
    def target(self) -> PlannedWaypoint | None:
        """The waypoint the robot walks to or holds at."""
        return self.plan[self.leg] if self.mode in (Mode.WALKING, Mode.HOLDING) else None

    def obey(self, now_ns: int, command: Command) -> None:
        """Take a command that has arrived."""
        if command.id in self.obeyed:
            return
        self.obeyed.add(command.id)
        self.report(now_ns, command.id, Stage.RECEIVED, "")
        names = ", ".join(waypoint.name for waypoint in command.waypoints)
        text = f"command {command.id} received: {command.kind} {names}"
        self._announce(now_ns, EventKind.COMMAND_RECEIVED, text, command_id=command.id)
        if self.mode is Mode.FALLEN:
            self.report(now_ns, command.id, Stage.REJECTED, FALL)
            return
        self.report(now_ns, command.id, Stage.ACCEPTED, "")
        self.command_id, self.plan, self.on_failure = command.id, command.waypoints, command.on_failure
        self.report(now_ns, command.id, Stage.STARTED, "")
        self._start_leg(now_ns, 0)

    def sense(self, now_ns: int, position: FloatArray, fell: bool) -> None:
        """Look at where the robot is, position (1, >= 2) [m], and whether it has fallen."""
        if self.mode is Mode.FALLEN:
            return
        if fell:
            walking = self.target is not None
            self.mode = Mode.FALLEN
            self._announce(now_ns, EventKind.FALL, "the robot has fallen", Severity.ERROR)
            if walking:
                self.report(now_ns, self.command_id, Stage.FAILED, FALL)
        elif self.mode is Mode.WALKING:
            self._walk(now_ns, self.plan[self.leg], position)
        elif self.mode is Mode.HOLDING and now_ns - self.since_ns >= self.plan[self.leg].hold_ns:
            waypoint = self.plan[self.leg]
            self._announce(now_ns, EventKind.HOLD_COMPLETED, f"hold at {waypoint.name} completed", waypoint=waypoint)
            self._start_leg(now_ns, self.leg + 1)

    def state(self) -> dict[str, object]:
        """Return all that a replay needs to go on from here, as plain data."""
        return {
            "mode": self.mode.value,
            "command_id": self.command_id,
            "plan": [asdict(waypoint) for waypoint in self.plan],
            "on_failure": self.on_failure,
            "leg": self.leg,
            "since_ns": self.since_ns,
            "reached": list(self.reached),
            "obeyed": sorted(self.obeyed),
        }

    def _walk(self, now_ns: int, waypoint: PlannedWaypoint, position: FloatArray) -> None:
        if now_ns == self.since_ns:
            return  # a leg is judged after its first control period, as in training
        if reached(self._acceptance, position, self.goals[:, 0])[0]:
            self.reached.append(waypoint.index)
            self._announce(now_ns, EventKind.WAYPOINT_REACHED, f"{waypoint.name} reached", waypoint=waypoint)
            if waypoint.hold_ns:
                self.mode, self.since_ns = Mode.HOLDING, now_ns
                text = f"holding at {waypoint.name} for {seconds(waypoint.hold_ns):g} s"
                self._announce(now_ns, EventKind.HOLD_STARTED, text, waypoint=waypoint)
            else:
                self._start_leg(now_ns, self.leg + 1)
        elif now_ns - self.since_ns >= waypoint.timeout_ns:
            self._give_up(now_ns, waypoint)

    def _give_up(self, now_ns: int, waypoint: PlannedWaypoint) -> None:
        text = f"{waypoint.name} not reached within {seconds(waypoint.timeout_ns):g} s"
        self._announce(now_ns, EventKind.WAYPOINT_TIMEOUT, text, Severity.WARNING, waypoint)
        if self.on_failure == "skip":
            self._announce(now_ns, EventKind.WAYPOINT_SKIPPED, f"{waypoint.name} skipped", Severity.WARNING, waypoint)
            self._start_leg(now_ns, self.leg + 1)
            return
        self.mode = Mode.FAILED
        self._announce(now_ns, EventKind.PLAN_FAILED, f"plan given up at {waypoint.name}", Severity.ERROR, waypoint)
        self.report(now_ns, self.command_id, Stage.FAILED, TIMEOUT)

    def _start_leg(self, now_ns: int, leg: int) -> None:
        if leg == len(self.plan):
            self.mode = Mode.DONE
            self._announce(now_ns, EventKind.PLAN_COMPLETED, f"command {self.command_id} completed")
            self.report(now_ns, self.command_id, Stage.COMPLETED, "")
            return
        self.mode, self.leg, self.since_ns = Mode.WALKING, leg, now_ns
        waypoint, following = self.plan[leg], self.plan[min(leg + 1, len(self.plan) - 1)]
        self._acceptance = Acceptance(waypoint.acceptance, waypoint.tolerance_m)
        self.goals = np.array([[[waypoint.x_m, waypoint.y_m], [following.x_m, following.y_m]]])
        self._announce(now_ns, EventKind.LEG_STARTED, f"walking to {waypoint.name}", waypoint=waypoint)

    def _announce(
        self,
        now_ns: int,
        kind: EventKind,
        text: str,
        severity: Severity = Severity.INFO,
        waypoint: PlannedWaypoint | None = None,
        command_id: int | None = None,
    ) -> None:
        index = -1 if waypoint is None else waypoint.index
        command = self.command_id if command_id is None else command_id
        self.announce(Event(now_ns, kind, Clock.ROBOT, severity, text, index, command))
