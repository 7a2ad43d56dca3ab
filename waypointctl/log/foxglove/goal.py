"""The short-range goal that the robot walks to, where that is none of the mission's waypoints.

An operator who steers sends a goal many times a second. It has a topic of its own, in messages of one entity: /scene,
which is sent whole, would be most of the log.
"""

from __future__ import annotations

from typing import Final

from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from waypointctl.log.foxglove.geometry import timestamp
from waypointctl.log.foxglove.scene import Standing, deletion, region
from waypointctl.log.messages import (
    FINAL_STAGES,
    Clock,
    Command,
    CommandStage,
    Event,
    EventKind,
    PlannedWaypoint,
    Stage,
)

_ID: Final = "goal"
_SETS_OUT: Final = frozenset({EventKind.LEG_STARTED, EventKind.RETURN_STARTED})


class GoalMarker:
    """Follows the goals of one flight; what it keeps is bounded by the commands that are open on board."""

    def __init__(self) -> None:
        """Show nothing."""
        self._goals: dict[int, PlannedWaypoint] = {}  # by the command that brought them
        self._shown = -1  # the command whose goal is shown

    def commanded(self, command: Command) -> None:
        """Take a command that has arrived."""
        for waypoint in command.waypoints:
            if waypoint.index < 0:
                self._goals[command.id] = waypoint

    def happened(self, event: Event) -> bytes | None:
        """Return foxglove.SceneUpdate where an event changes what the robot walks to."""
        if event.kind not in _SETS_OUT:
            return None
        goal = self._goals.get(event.command_id)
        if event.kind is not EventKind.LEG_STARTED or event.waypoint >= 0 or goal is None:
            return self._remove(event.time_ns)
        self._shown = event.command_id
        entity = region(_ID, goal, Standing.TARGET, goal.name)
        entity.timestamp.CopyFrom(timestamp(event.time_ns))
        entity.frame_locked = True
        data: bytes = SceneUpdate(entities=[entity]).SerializeToString()
        return data

    def advanced(self, it: CommandStage) -> bytes | None:
        """Return foxglove.SceneUpdate where a stage ends the way to the goal that is shown."""
        if it.clock is not Clock.ROBOT or it.stage not in FINAL_STAGES:
            return None
        self._goals.pop(it.command_id, None)
        superseded = it.stage is Stage.SUPERSEDED  # what takes its place sets out at the same moment
        return None if superseded or it.command_id != self._shown else self._remove(it.time_ns)

    def _remove(self, time_ns: int) -> bytes | None:
        if self._shown < 0:
            return None
        self._shown = -1
        data: bytes = SceneUpdate(deletions=[deletion(time_ns, _ID)]).SerializeToString()
        return data
