"""A leg: the way to one waypoint, its clock, and whether the robot gets any closer."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum, auto

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.rules import Rules
from waypointctl.log.messages import PlannedWaypoint
from waypointctl.mission.fields import Acceptance
from waypointctl.task.progress import reached

FloatArray = NDArray[np.float64]


class LegStatus(Enum):
    """Status of a leg."""

    ON_THE_WAY = auto()
    REACHED = auto()
    NEAR_MISS = auto()  # within the stopped tolerance, without progress
    STUCK = auto()
    OUT_OF_TIME = auto()


@dataclass(slots=True)
class Leg:
    """The way to one waypoint.

    Attributes:
        waypoint: where to.
        following: the waypoint after that; the waypoint itself where it is the last.
        since_ns: when its clock began.
        tries: how often it has been begun.
        best_m: the smallest distance that counted as progress.
        best_ns: when that was.
        goals: this waypoint and the next, (1, 2, 2) [m], as the policy's observation takes them.
    """

    waypoint: PlannedWaypoint
    following: PlannedWaypoint
    since_ns: int
    tries: int = 1
    best_m: float = math.inf
    best_ns: int = 0
    goals: FloatArray = field(init=False)
    _acceptance: Acceptance = field(init=False)

    def __post_init__(self) -> None:
        """Work out what every control step needs."""
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
