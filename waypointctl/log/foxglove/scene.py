"""The 3D scene: the robot's shapes on its bodies, and the waypoints with the regions that accept the robot."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import Enum
from typing import Final

from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.CylinderPrimitive_pb2 import CylinderPrimitive
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.TextPrimitive_pb2 import TextPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from waypointctl.log.foxglove.motion import pose, rotate, timestamp
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
from waypointctl.sim.geometry import WORLD, Geom

# A scene is sent at every leg: with all of a thousand waypoints in each, the log would be mostly that.
MAX_DRAWN: Final = 100
DRAWN_BEFORE: Final = 25  # of these, the most that lie before the current one
REGION_HEIGHT_M: Final = 0.1
LABEL_HEIGHT_M: Final = 0.4
PLANE_THICKNESS_M: Final = 0.02
ENDLESS_PLANE_M: Final = 100.0  # the side drawn of a plane whose size is 0, MuJoCo's word for endless


class Standing(Enum):
    """How a waypoint stands, as the colour (r, g, b, a) it is drawn in."""

    PENDING = (0.35, 0.55, 0.95, 0.4)
    TARGET = (1.0, 0.65, 0.1, 0.6)
    REACHED = (0.2, 0.8, 0.35, 0.5)
    MISSED = (0.9, 0.2, 0.2, 0.5)


def near(waypoints: Sequence[PlannedWaypoint], focus: int) -> Sequence[PlannedWaypoint]:
    """Return the waypoints to draw while the one of index `focus` matters: all, or of many those around it in order."""
    place = next((place for place, waypoint in enumerate(waypoints) if waypoint.index == focus), 0)
    begin = max(0, min(place - DRAWN_BEFORE, len(waypoints) - MAX_DRAWN))
    return waypoints[begin : begin + MAX_DRAWN]


def scene(
    time_ns: int,
    geoms: Iterable[Geom],
    waypoints: Iterable[PlannedWaypoint],
    standings: dict[int, Standing],
    gone: Iterable[int] = (),
    surroundings: Iterable[SceneEntity] = (),
) -> bytes:
    """Return foxglove.SceneUpdate with robot, `waypoints` and `surroundings`, and without the waypoints `gone`.

    All of them, each time: after a seek a viewer knows no more than the last message on the topic.
    """
    update = SceneUpdate(deletions=[deletion(time_ns, _entity_id(index)) for index in gone])
    for waypoint in waypoints:
        standing = standings.get(waypoint.index, Standing.PENDING)
        label = f"{waypoint.index + 1} {waypoint.name}".strip()
        update.entities.append(region(_entity_id(waypoint.index), waypoint, standing, label))
    bodies: dict[str, SceneEntity] = {}
    for geom in geoms:
        entity = bodies.setdefault(geom.body, SceneEntity(id=f"body {geom.body}", frame_id=geom.body))
        _add_geom(entity, geom)
    update.entities.extend(bodies.values())
    update.entities.extend(surroundings)
    for entity in update.entities:
        entity.timestamp.CopyFrom(timestamp(time_ns))
        entity.frame_locked = True
    return update.SerializeToString()


def waypoint_poses(time_ns: int, waypoints: Iterable[PlannedWaypoint]) -> bytes:
    """Return foxglove.PosesInFrame of the waypoints, in their order."""
    poses = [pose((waypoint.x_m, waypoint.y_m, 0.0)) for waypoint in waypoints]
    return PosesInFrame(timestamp=timestamp(time_ns), frame_id=WORLD, poses=poses).SerializeToString()


def _entity_id(index: int) -> str:
    return f"waypoint {index}"


def _color(rgba: tuple[float, float, float, float]) -> Color:
    r, g, b, a = rgba
    return Color(r=r, g=g, b=b, a=a)


def deletion(time_ns: int, entity_id: str) -> SceneEntityDeletion:
    """Return the deletion of an entity that was drawn at `time_ns` or before."""
    return SceneEntityDeletion(id=entity_id, timestamp=timestamp(time_ns + 1))  # it deletes what is earlier than that


def region(entity_id: str, waypoint: PlannedWaypoint, standing: Standing, label: str) -> SceneEntity:
    """Return the region in which `waypoint` accepts the robot, with its label."""
    side = 2 * waypoint.tolerance_m
    size = Vector3(x=side, y=side, z=REGION_HEIGHT_M)
    at = pose((waypoint.x_m, waypoint.y_m, REGION_HEIGHT_M / 2))
    entity = SceneEntity(id=entity_id, frame_id=WORLD)
    color = _color(standing.value)
    if waypoint.acceptance == "box":
        entity.cubes.append(CubePrimitive(pose=at, size=size, color=color))
    else:
        entity.cylinders.append(CylinderPrimitive(pose=at, size=size, bottom_scale=1, top_scale=1, color=color))
    above = pose((waypoint.x_m, waypoint.y_m, LABEL_HEIGHT_M))
    white = Color(r=1, g=1, b=1, a=1)
    entity.texts.append(TextPrimitive(pose=above, billboard=True, font_size=0.3, color=white, text=label))
    return entity


def _add_geom(entity: SceneEntity, geom: Geom) -> None:
    at, color = pose(geom.position, geom.quaternion), _color(geom.rgba)
    a, b, c = (2 * half for half in geom.size)
    match geom.kind:
        case "sphere":
            entity.spheres.append(SpherePrimitive(pose=at, size=Vector3(x=a, y=a, z=a), color=color))
        case "capsule":
            _add_capsule(entity, geom, color)
        case "ellipsoid":
            entity.spheres.append(SpherePrimitive(pose=at, size=Vector3(x=a, y=b, z=c), color=color))
        case "cylinder":
            size = Vector3(x=a, y=a, z=b)
            entity.cylinders.append(CylinderPrimitive(pose=at, size=size, bottom_scale=1, top_scale=1, color=color))
        case "box":
            entity.cubes.append(CubePrimitive(pose=at, size=Vector3(x=a, y=b, z=c), color=color))
        case "plane":
            size = Vector3(x=a or ENDLESS_PLANE_M, y=b or ENDLESS_PLANE_M, z=PLANE_THICKNESS_M)
            nx, ny, nz = rotate(geom.quaternion, (0.0, 0.0, PLANE_THICKNESS_M / 2))
            x, y, z = geom.position
            below = pose((x - nx, y - ny, z - nz), geom.quaternion)  # the plane is the slab's upper face
            entity.cubes.append(CubePrimitive(pose=below, size=size, color=color))


def _add_capsule(entity: SceneEntity, geom: Geom, color: Color) -> None:
    # Foxglove has no capsule: a cylinder between two spheres.
    width, length = 2 * geom.size[0], 2 * geom.size[1]
    tube = Vector3(x=width, y=width, z=length)
    at = pose(geom.position, geom.quaternion)
    entity.cylinders.append(CylinderPrimitive(pose=at, size=tube, bottom_scale=1, top_scale=1, color=color))
    ball = Vector3(x=width, y=width, z=width)
    for end in (-geom.size[1], geom.size[1]):
        dx, dy, dz = rotate(geom.quaternion, (0.0, 0.0, end))
        x, y, z = geom.position
        entity.spheres.append(SpherePrimitive(pose=pose((x + dx, y + dy, z + dz)), size=ball, color=color))


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
        """Return foxglove.SceneUpdate where an event changes the robot's goal."""
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
