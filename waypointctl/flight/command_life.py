"""The life of a command: its stages, which of them may follow which, and which report of a stage counts.

    on the ground and on the link   QUEUED -> SENT, LOST; UNKNOWN while an acknowledgement is overdue
    on board                        RECEIVED -> ACCEPTED -> STARTED -> a final stage, or a final stage sooner

The robot alone takes a command from stage to stage on board, and none follows a final one. The ground learns of it from
acknowledgements and frames of telemetry, which the link may lose, duplicate and bring in any order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from waypointctl.log.messages import FINAL_STAGES, PlannedWaypoint, Stage

NOT_STARTED: Final = frozenset({Stage.RECEIVED, Stage.ACCEPTED})
ONBOARD: Final = NOT_STARTED | {Stage.STARTED}  # arrived, and not over
NEVER_STARTED: Final = NOT_STARTED | {Stage.REJECTED, Stage.SKIPPED}  # none of these follows STARTED

_NAMED: Final = 12  # waypoints that a text names one by one
FLIGHT_ENDED: Final = "flight ended"  # reason of a command that was still open at the end of the flight

# A command that ends on arrival was never accepted.
_NEXT: Final[Mapping[Stage, frozenset[Stage]]] = {
    Stage.RECEIVED: FINAL_STAGES - {Stage.COMPLETED, Stage.FAILED, Stage.SUPERSEDED} | {Stage.ACCEPTED},
    Stage.ACCEPTED: FINAL_STAGES - {Stage.REJECTED} | {Stage.STARTED},
    Stage.STARTED: FINAL_STAGES - {Stage.REJECTED, Stage.SKIPPED},
}


def may_follow(stage: Stage, after: Stage) -> bool:
    """Return whether a command on board may come to a stage after another."""
    return stage in _NEXT.get(after, ())


def names(waypoints: Sequence[PlannedWaypoint]) -> str:
    """Return the names of some waypoints, for people; of many the first and the last, and how many they are."""
    if len(waypoints) <= _NAMED:
        return ", ".join(waypoint.name for waypoint in waypoints)
    return f"{waypoints[0].name} to {waypoints[-1].name}, {len(waypoints):,} waypoints"


@dataclass(frozen=True, slots=True)
class StageReport:
    """A stage of a command as the ground knows it."""

    stage: Stage  # of it
    reason: str  # empty, or why it was rejected or failed
    time_ns: int  # on the clock of the side that recorded the stage

    def counts_after(self, known: StageReport | None) -> bool:
        """Return whether this report from the robot replaces what is known; False for one that arrives out of order."""
        if known is None or known.stage not in ONBOARD | FINAL_STAGES:
            return True
        if known.stage in FINAL_STAGES:
            return False
        return self.stage in FINAL_STAGES or self.time_ns >= known.time_ns
