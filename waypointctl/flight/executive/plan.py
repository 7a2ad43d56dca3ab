"""The plan on board: waypoints in order, each with the command that brought it, and the leg to the current one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
from enum import Enum, auto
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.rules import Rules
from waypointctl.log.messages import Command, CommandKind, PlannedWaypoint
from waypointctl.mission.fields import Acceptance
from waypointctl.task.progress import reached

SAVED: Final = 256  # items at most in a checkpoint: what all checkpoints take is to grow with the flight's length alone

FloatArray = NDArray[np.float64]


@dataclass(slots=True)
class PlanItem:
    """A waypoint of the plan."""

    waypoint: PlannedWaypoint  # as it was commanded, or as it was changed since
    command_id: int  # of the command that brought it
    on_failure: str  # what that command wants when the leg fails; empty for the robot's own rule
    released: bool  # whether the robot may drive to it
    over: bool = field(default=False, init=False)  # reached and its task done, skipped, or taken back
    alone: bool  # commanded as a single goal, not as part of a plan


@dataclass(slots=True)
class Plan:
    """The plan on board. Items that are over stay, so that counts and places never shift."""

    items: list[PlanItem] = field(default_factory=list)  # in order
    at: int = 0  # the place of the item under way

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
            self.items.append(PlanItem(waypoint, command.id, command.on_failure, released, alone))

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
        begin = max(0, min(self.at, len(self.items) - SAVED))
        saved = self.items[begin : begin + SAVED]
        part = {"begin": begin, "of": len(self.items)} if len(saved) < len(self.items) else {}
        return {"at": self.at, "items": [asdict(item) for item in saved], **part}


class LegStatus(Enum):
    """Status of a leg."""

    ON_THE_WAY = auto()
    REACHED = auto()
    NEAR_MISS = auto()  # within the stopped tolerance, without progress
    STUCK = auto()
    OUT_OF_TIME = auto()


@dataclass(slots=True)
class Leg:
    """The way to one waypoint."""

    waypoint: PlannedWaypoint  # where to
    following: PlannedWaypoint  # the waypoint after that; the waypoint itself where it is the last
    since_ns: int  # when its clock began
    tries: int = 1  # how often it has been begun
    best_m: float = math.inf  # the smallest distance that counted as progress
    best_ns: int = field(init=False)  # when that was, or when its clock began
    # This waypoint and the next, (1, 2, 2) [m], as the policy's observation takes them
    goals: FloatArray = field(init=False)
    _acceptance: Acceptance = field(init=False)

    def __post_init__(self) -> None:
        """Work out what every control step needs."""
        self.best_ns = self.since_ns
        self.aim(self.waypoint, self.following)

    def aim(self, waypoint: PlannedWaypoint, following: PlannedWaypoint) -> None:
        """Change the waypoint, or the one after it, while the leg is under way."""
        self.waypoint, self.following = waypoint, following
        self._acceptance = Acceptance.of(waypoint.acceptance, waypoint.tolerance_m)
        self.goals = np.array([[[waypoint.x_m, waypoint.y_m], [following.x_m, following.y_m]]])

    def begin_again(self, now_ns: int) -> None:
        """Try once more."""
        self.since_ns, self.best_m, self.best_ns = now_ns, math.inf, now_ns
        self.tries += 1

    def shift(self, by_ns: int) -> None:
        """Leave out a time in which its clock stood still."""
        self.since_ns += by_ns
        self.best_ns += by_ns

    def distance_m(self, position: FloatArray) -> float:
        """Return how far a position (1, >= 2) [m] is from the waypoint."""
        return math.hypot(position[0, 0] - self.waypoint.x_m, position[0, 1] - self.waypoint.y_m)

    def assess(self, now_ns: int, position: FloatArray, rules: Rules) -> LegStatus:
        """Look at where the robot is, position (1, >= 2) [m]."""
        if now_ns == self.since_ns:
            return LegStatus.ON_THE_WAY  # a leg is assessed after its first control period, as in training
        if reached(self._acceptance, position, self.goals[:, 0])[0]:
            return LegStatus.REACHED
        if rules.watches_progress and self._stalled(now_ns, position, rules):
            if self.distance_m(position) <= rules.slip_m:
                return LegStatus.NEAR_MISS
            if rules.stuck_fails:
                return LegStatus.STUCK
        return LegStatus.OUT_OF_TIME if now_ns - self.since_ns >= self.waypoint.timeout_ns else LegStatus.ON_THE_WAY

    def state(self) -> dict[str, object]:
        """Return what is not in the plan, as plain data."""
        best_m = self.best_m if math.isfinite(self.best_m) else None
        return {
            "since_ns": self.since_ns,
            "tries": self.tries,
            "best_m": best_m,
            "best_ns": self.best_ns,
            "goals": self.goals[0].tolist(),
        }

    def _stalled(self, now_ns: int, position: FloatArray, rules: Rules) -> bool:
        distance_m = self.distance_m(position)
        if distance_m <= self.best_m - rules.progress_m:
            self.best_m, self.best_ns = distance_m, now_ns
        return now_ns - self.best_ns >= rules.stall_ns
