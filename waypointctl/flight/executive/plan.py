"""The plan on board: waypoints in order, each with the command that brought it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import islice
from typing import Final

from waypointctl.log.messages import Command, CommandKind, PlannedWaypoint

_NAMED: Final = 12  # waypoints that a text names one by one
_TOLD: Final = 256  # of the items, in a checkpoint: what all checkpoints take is to grow with the flight's length alone


def names(waypoints: Sequence[PlannedWaypoint]) -> str:
    """Return the names of some waypoints, for people; of many the first and the last, and how many they are."""
    if len(waypoints) <= _NAMED:
        return ", ".join(waypoint.name for waypoint in waypoints)
    return f"{waypoints[0].name} to {waypoints[-1].name}, {len(waypoints):,} waypoints"


@dataclass(slots=True)
class PlanItem:
    """A waypoint of the plan.

    Attributes:
        waypoint: as it was commanded, or as it was changed since.
        command_id: of the command that brought it.
        on_failure: what that command wants when the leg fails; empty for the robot's own rule.
        released: whether the robot may drive to it.
        over: reached and its task done, skipped, or taken back.
        alone: commanded as a single goal, not as part of a plan.
    """

    waypoint: PlannedWaypoint
    command_id: int
    on_failure: str
    released: bool
    over: bool = False
    alone: bool = False


@dataclass(slots=True)
class Plan:
    """The plan on board. Items that are over stay, so that counts and places never shift.

    Attributes:
        items: in order.
        at: the place of the item under way.
    """

    items: list[PlanItem] = field(default_factory=list)
    at: int = 0

    @property
    def current(self) -> PlanItem | None:
        """The item under way; None when all are over."""
        return self.items[self.at] if self.at < len(self.items) else None

    @property
    def following(self) -> PlannedWaypoint | None:
        """The waypoint after the current one, if it is released."""
        item = next((item for item in islice(self.items, self.at + 1, None) if not item.over), None)
        return item.waypoint if item is not None and item.released else None

    @property
    def released(self) -> int:
        """How many waypoints are released, counted from the plan's first."""
        return next((i for i, item in enumerate(self.items) if not item.released), len(self.items))

    def extend(self, command: Command) -> None:
        """Add a command's waypoints, with its `released` waypoints released, from the first; -1 for all."""
        alone = command.kind is CommandKind.GO_TO
        for place, waypoint in enumerate(command.waypoints):
            released = command.released < 0 or place < command.released
            self.items.append(PlanItem(waypoint, command.id, command.on_failure, released, alone=alone))

    def release(self, count: int) -> None:
        """Release the first `count` waypoints of the plan; -1 for all."""
        for item in self.items if count < 0 else self.items[:count]:
            item.released = True

    def end(self, items: Iterable[PlanItem]) -> None:
        """Mark items as over, and move on to the first that is not."""
        for item in items:
            item.over = True
        while self.at < len(self.items) and self.items[self.at].over:
            self.at += 1

    def open_items(self, command_id: int | None = None) -> list[PlanItem]:
        """Return what is not over, of one command or of all."""
        to_come = [item for item in self.items[self.at :] if not item.over]
        return to_come if command_id is None else [item for item in to_come if item.command_id == command_id]

    def has_open(self, command_id: int) -> bool:
        """Return whether a command has waypoints left."""
        return any(item.command_id == command_id and not item.over for item in islice(self.items, self.at, None))

    def open_commands(self) -> list[int]:
        """Return the commands that have waypoints left, in the order of the plan."""
        return list(dict.fromkeys(item.command_id for item in self.open_items()))

    def change(
        self, items: Iterable[PlanItem], *, tolerance_m: float | None = None, timeout_ns: int | None = None
    ) -> None:
        """Give waypoints another tolerance or another time."""
        for item in items:
            if tolerance_m is not None:
                item.waypoint = replace(item.waypoint, tolerance_m=tolerance_m)
            if timeout_ns is not None:
                item.waypoint = replace(item.waypoint, timeout_ns=timeout_ns)

    def state(self) -> dict[str, object]:
        """Return it as plain data; of a long plan some items from the one under way on, and which those are."""
        begin = max(0, min(self.at, len(self.items) - _TOLD))
        saved = self.items[begin : begin + _TOLD]
        part = {"begin": begin, "of": len(self.items)} if len(saved) < len(self.items) else {}
        return {"at": self.at, "items": [asdict(item) for item in saved], **part}
