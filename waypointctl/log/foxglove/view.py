"""The translator: our messages in, messages for viewers out."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.resources import files
from typing import Final, NamedTuple

from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Odometry_pb2 import Odometry
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from waypointctl.log.foxglove.motion import Motion, Trail, timestamp
from waypointctl.log.foxglove.scene import GoalMarker, Standing, near, scene, waypoint_poses
from waypointctl.log.foxglove.surroundings import Surroundings
from waypointctl.log.header import Kinematics, MissionSetting
from waypointctl.log.messages import (
    Command,
    CommandStage,
    Event,
    EventKind,
    LinkRecord,
    Message,
    PlannedWaypoint,
    Severity,
    State,
    Telemetry,
)
from waypointctl.units import NS_PER_S

VIEW_TOPICS: Final = {
    "/tf": FrameTransforms,
    "/odometry": Odometry,
    "/joints": JointStates,
    "/scene": SceneUpdate,
    "/goal": SceneUpdate,
    "/waypoints": PosesInFrame,
    "/path": PosesInFrame,
    "/log": Log,
}
MOTION_PERIOD_NS: Final = NS_PER_S // 25  # every second step of a 50 Hz controller: an eye sees no more
TRAIL_PERIOD_NS: Final = NS_PER_S
_NO_SETTING: Final = MissionSetting()

_LEVELS: Final = {Severity.INFO: Log.INFO, Severity.WARNING: Log.WARNING, Severity.ERROR: Log.ERROR}
_STANDINGS: Final = {
    EventKind.LEG_STARTED: Standing.TARGET,
    EventKind.WAYPOINT_REACHED: Standing.REACHED,
    EventKind.WAYPOINT_TIMEOUT: Standing.MISSED,
    EventKind.WAYPOINT_SKIPPED: Standing.MISSED,
}


def layout(root: str, *, camera: bool) -> bytes:
    """Return the layout that travels in the log, its view from behind the body `root`; with `camera` its pictures too.

    layout.json is as Foxglove and Lichtblick export a layout, and import it; they publish no schema of it.
    """
    whole = json.loads(files("waypointctl.log.foxglove").joinpath("layout.json").read_bytes())
    panels, scene_and_camera = whole["configById"], whole["layout"]["first"]
    panels["3D!scene"]["followTf"] = root
    if not camera:
        del panels["Image!camera"]
        scene_and_camera["first"] = "3D!scene"
    return json.dumps(whole, indent=2).encode() + b"\n"


class Frame(NamedTuple):
    """One message for viewers."""

    topic: str
    time_ns: int
    data: bytes


class FoxgloveView:
    """Follows one flight."""

    def __init__(
        self, kinematics: Kinematics, waypoints: Sequence[PlannedWaypoint], setting: MissionSetting = _NO_SETTING
    ) -> None:
        """Know the robot, and what the mission has from the start."""
        self._geoms = kinematics.geoms
        self._motion = Motion(kinematics)
        self._trail = Trail()
        self._goal = GoalMarker()
        self._surroundings = Surroundings(setting, kinematics.body_names[0])
        self._waypoints = {waypoint.index: waypoint for waypoint in waypoints}
        self._standings: dict[int, Standing] = {}
        self._focus = -1  # the waypoint that the last event was about
        self._drawn: set[int] = set()
        self._motion_due_ns = 0
        self._trail_due_ns = 0

    def start(self) -> list[Frame]:
        """Return what viewers see before anything has moved."""
        return [*self._targets(0), self._scene(0)]

    def __call__(self, message: Message) -> Sequence[Frame]:
        """Return the viewers' messages for `message`, often none."""
        match message:
            case State():
                return self._moved(message)
            case Command():
                return self._commanded(message)
            case Event():
                return self._happened(message)
            case CommandStage():
                return _if_any("/goal", message.time_ns, self._goal.advanced(message))
            case LinkRecord():
                self._surroundings.lost(message)
                return ()
            case Telemetry():  # while physics sleeps there are no states
                is_due = self._surroundings.is_due(message.received_ns)
                return (self._scene(message.received_ns),) if is_due else ()
            case _:
                return ()

    def _moved(self, state: State) -> Sequence[Frame]:
        now = state.time_ns
        if now < self._motion_due_ns:
            return ()
        self._motion_due_ns = now + MOTION_PERIOD_NS
        moved = self._motion(state)
        frames = [
            Frame("/tf", now, moved.transforms),
            Frame("/odometry", now, moved.odometry),
            Frame("/joints", now, moved.joints),
        ]
        if now >= self._trail_due_ns:
            self._trail_due_ns = now + TRAIL_PERIOD_NS
            frames.append(
                Frame("/path", now, self._trail.extend(now, state.qpos[:3].tolist(), state.qpos[3:7].tolist()))
            )
        if self._surroundings.moved(state):
            frames.append(self._scene(now))
        return frames

    def _commanded(self, command: Command) -> Sequence[Frame]:
        self._goal.commanded(command)
        known = {waypoint.index: waypoint for waypoint in command.waypoints if waypoint.index >= 0}
        if known.items() <= self._waypoints.items():
            return ()
        self._waypoints = dict(sorted((self._waypoints | known).items()))
        return [*self._targets(command.received_ns), self._scene(command.received_ns)]

    def _happened(self, event: Event) -> Sequence[Frame]:
        line = Log(
            timestamp=timestamp(event.time_ns), level=_LEVELS[event.severity], message=event.text, name=event.clock
        )
        frames = [Frame("/log", event.time_ns, line.SerializeToString())]
        frames += _if_any("/goal", event.time_ns, self._goal.happened(event))
        is_changed = self._surroundings.happened(event)
        standing = _STANDINGS.get(event.kind)
        if standing is not None and event.waypoint in self._waypoints:
            # A goal that is sent again and again draws the scene once.
            is_changed |= (self._focus, self._standings.get(event.waypoint)) != (event.waypoint, standing)
            self._standings[event.waypoint] = standing
            self._focus = event.waypoint
        if is_changed:
            frames.append(self._scene(event.time_ns))
        return frames

    def _targets(self, time_ns: int) -> list[Frame]:
        return [Frame("/waypoints", time_ns, waypoint_poses(time_ns, self._waypoints.values()))]

    def _scene(self, time_ns: int) -> Frame:
        waypoints = near(tuple(self._waypoints.values()), self._focus)
        drawn = {waypoint.index for waypoint in waypoints}
        gone, around = sorted(self._drawn - drawn), self._surroundings.entities(time_ns)
        data = scene(time_ns, self._geoms, waypoints, self._standings, gone, around)
        self._drawn = drawn
        return Frame("/scene", time_ns, data)


def _if_any(topic: str, time_ns: int, data: bytes | None) -> Sequence[Frame]:
    return () if data is None else (Frame(topic, time_ns, data),)
