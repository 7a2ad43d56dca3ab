"""The operator on the ground: a script that decides from belief alone, and how much it leaves to the robot."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Final

from waypointctl.log.messages import FINAL_STAGES, Ack, CommandKind, PlannedWaypoint, Stage, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.ops.belief import Belief
from waypointctl.ops.executive import TIMEOUT
from waypointctl.units import ns


@dataclass(frozen=True, slots=True)
class Order:
    """What the operator wants sent, before it has an id and a time."""

    kind: CommandKind
    waypoints: tuple[PlannedWaypoint, ...]
    on_failure: str


class Operator(ABC):
    """One who commands the robot. It hears only what the downlink brings, when it brings it."""

    def __init__(self, mission: Mission) -> None:
        """Take charge of a mission."""
        self.belief = Belief()
        self.finished = False
        self.verdict = ""  # why it is finished, where that is a failure
        self._on_failure: str = mission.on_failure
        self._plan = planned_waypoints(mission)

    @abstractmethod
    def begin(self) -> list[Order]:
        """Return what to send at mission start."""

    def hear(self, message: Ack | Telemetry) -> list[Order]:
        """Take what has arrived; return what to send on hearing it."""
        self.belief.hear(message)
        if isinstance(message, Ack) and message.stage in FINAL_STAGES:
            return self._concluded(message)
        return []

    @abstractmethod
    def _concluded(self, ack: Ack) -> list[Order]:
        """Decide what follows the end of a command."""

    def _finish(self, verdict: str = "") -> list[Order]:
        self.finished, self.verdict = True, verdict
        return []


class MissionOperator(Operator):
    """Sends the whole plan once and waits: autonomy `mission`."""

    def begin(self) -> list[Order]:
        """Send the plan."""
        return [Order(CommandKind.UPLOAD_PLAN, self._plan, self._on_failure)]

    def _concluded(self, ack: Ack) -> list[Order]:
        return self._finish(ack.reason)


class WaypointOperator(Operator):
    """Sends one waypoint, waits to hear how it went, sends the next: autonomy `waypoint`, move and wait."""

    def __init__(self, mission: Mission) -> None:
        """Take charge of a mission."""
        super().__init__(mission)
        self._sent = 0

    def begin(self) -> list[Order]:
        """Send the first waypoint."""
        return self._next()

    def _next(self) -> list[Order]:
        waypoint = self._plan[self._sent]
        self._sent += 1
        # What follows a failure is the operator's to decide here: on board the command just fails.
        return [Order(CommandKind.GO_TO, (waypoint,), "abort")]

    def _concluded(self, ack: Ack) -> list[Order]:
        timed_out = ack.stage is Stage.FAILED and ack.reason == TIMEOUT
        if ack.stage is not Stage.COMPLETED and not (timed_out and self._on_failure == "skip"):
            return self._finish(ack.reason)
        return self._next() if self._sent < len(self._plan) else self._finish()


OPERATORS: Final = {"mission": MissionOperator, "waypoint": WaypointOperator}


def operator_for(mission: Mission) -> Operator:
    """Return the operator that the mission's autonomy asks for."""
    return OPERATORS[mission.autonomy](mission)


def planned_waypoints(mission: Mission) -> tuple[PlannedWaypoint, ...]:
    """Return the mission's waypoints as they are commanded."""
    return tuple(
        PlannedWaypoint(
            index=leg.index,
            name=leg.name,
            x_m=leg.x_m,
            y_m=leg.y_m,
            acceptance=leg.acceptance,
            tolerance_m=leg.tolerance_m,
            timeout_ns=ns(leg.timeout_s),
            hold_ns=ns(leg.hold_s),
        )
        for leg in mission.legs()
    )
