"""Commands without ids, and a robot to which they come in any order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tests.flight.executive.rig import Rig
from waypointctl.log.messages import CommandKind, Mode, PlannedWaypoint


@dataclass(frozen=True)
class Sent:
    """A command before it has an id."""

    kind: CommandKind
    waypoints: tuple[PlannedWaypoint, ...] = ()
    released: int = -1
    target_id: int = -1
    value: float = 1.0
    not_before: float | None = None

    @property
    def start(self) -> float:
        """When it is to start, if it arrives at 1 s."""
        return 1.0 if self.not_before is None else self.not_before


def send(rig: Rig, now: float, one: Sent, number: int, **arguments: Any) -> None:
    """Hand over a command."""
    arguments = {"released": one.released, "target_id": one.target_id, "value": one.value, **arguments}
    rig.send(now, one.kind, *one.waypoints, id=number, on_failure="abort", **arguments)


def arrived(stream: list[Sent], order: tuple[int, ...]) -> Rig:
    """Return a robot that got a stream at 1 s, in an order; ids are places in the stream, from 1."""
    rig = Rig()
    for number in order:
        send(rig, 1.0, stream[number - 1], number, not_before=stream[number - 1].not_before)
    rig.sense(1.02, "start")
    return rig


def busy(rig: Rig) -> tuple[object, ...]:
    """Return what a robot is doing, and is still to do."""
    executive = rig.executive
    plan: Any = executive.state()["plan"]
    open_items = [(item["waypoint"], item["released"]) for item in plan["items"] if not item["over"]]
    return executive.mode, executive.goals.tolist() if executive.policy_active else None, open_items


def doing(rig: Rig) -> tuple[object, ...]:
    """Return what a robot is doing and is still to do, and, if it pauses, what it does when it is resumed."""
    mode = rig.executive.mode
    if mode is Mode.PAUSED:
        rig.send(30.0, CommandKind.RESUME, id=100)
    return mode, rig.executive.target, *busy(rig)
