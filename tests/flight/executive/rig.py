"""An executive without a robot: told where it is, and remembering all that it says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from waypointctl.flight.executive.executive import Executive
from waypointctl.flight.executive.rules import Rules
from waypointctl.log.messages import (
    Command,
    CommandKind,
    CommandStage,
    Event,
    EventKind,
    Mode,
    PlannedWaypoint,
    Stage,
)

SECOND: Final = 1_000_000_000
A: Final = PlannedWaypoint(0, "a", 5.0, 0.0, "box", 0.5, 10 * SECOND, 0)
B: Final = PlannedWaypoint(1, "b", 5.0, 5.0, "radius", 0.5, 20 * SECOND, 0)
C: Final = PlannedWaypoint(2, "c", 0.0, 5.0, "box", 0.5, 30 * SECOND, 0)
HOLD: Final = replace(A, hold_ns=2 * SECOND)
AT: Final = {"start": (0.0, 0.0), "a": (5.0, 0.0), "b": (5.0, 5.0), "c": (0.0, 5.0)}


class Rig:
    """An executive and all that it said. Times are in [s]."""

    def __init__(self, **rules: Any) -> None:
        self.stages_said: list[CommandStage] = []
        self.reminders: list[CommandStage] = []
        self.events: list[Event] = []
        self.on_stage: Callable[[CommandStage], None] = lambda _: None
        self.executive = Executive(self.report, self.events.append, remind=self.reminders.append, rules=Rules(**rules))

    def report(self, stage: CommandStage) -> None:
        """Remember a stage."""
        self.stages_said.append(stage)
        self.on_stage(stage)

    def command(self, now: float, *plan: PlannedWaypoint, id: int = 1, on_failure: str = "abort") -> None:
        """Hand over a plan."""
        self.send(now, CommandKind.UPLOAD_PLAN, *plan, id=id, on_failure=on_failure)

    def send(
        self,
        now: float,
        kind: CommandKind,
        *waypoints: PlannedWaypoint,
        id: int,
        on_failure: str = "",
        not_before: float | None = None,
        expires: float | None = None,
        **arguments: Any,
    ) -> Stage:
        """Hand over a command; return the stage that it has come to."""
        now_ns = round(now * SECOND)
        self.executive.execute(
            now_ns,
            Command(
                id=id,
                kind=kind,
                waypoints=waypoints,
                on_failure=on_failure,
                issued_ns=0,
                received_ns=now_ns,
                not_before_ns=-1 if not_before is None else round(not_before * SECOND),
                expires_ns=-1 if expires is None else round(expires * SECOND),
                **arguments,
            ),
        )
        return self.stage(id)

    def sense(self, now: float, where: str | tuple[float, float], *, fell: bool = False) -> Mode:
        """Let it look at the world."""
        position = AT[where] if isinstance(where, str) else where
        self.executive.sense(round(now * SECOND), np.array([[*position, 0.5]]), fell, 0.5)
        return self.executive.mode

    @property
    def reports(self) -> list[tuple[int, int, Stage, str]]:
        """Every stage said: (time [ns], command, stage, reason)."""
        return [(it.time_ns, it.command_id, it.stage, it.reason) for it in self.stages_said]

    @property
    def stages(self) -> list[Stage]:
        return [it.stage for it in self.stages_said]

    @property
    def kinds(self) -> list[EventKind]:
        return [event.kind for event in self.events]

    def stage(self, id: int) -> Stage:
        """Return the last stage said of a command."""
        return self.ended(id)[0]

    def ended(self, id: int) -> tuple[Stage, str]:
        """Return the last stage said of a command, and its reason."""
        return [(it.stage, it.reason) for it in self.stages_said if it.command_id == id][-1]

    def stages_of(self, id: int) -> list[Stage]:
        """Return all stages said of a command."""
        return [it.stage for it in self.stages_said if it.command_id == id]
