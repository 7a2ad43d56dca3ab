"""What is around the robot in the 3D scene: zones, home, how the link is, and where messages were not delivered."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.TextPrimitive_pb2 import TextPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from waypointctl.log.foxglove.motion import pose
from waypointctl.log.foxglove.scene import LABEL_HEIGHT_M, Standing, region
from waypointctl.log.header import MissionSetting
from waypointctl.log.messages import NOT_DELIVERED, Event, EventKind, LinkRecord, State
from waypointctl.mission.onboard import Zone
from waypointctl.sim.geometry import WORLD
from waypointctl.units import NS_PER_S, seconds

MAX_CORNERS: Final = 2000  # drawn of all zones together, for the same reason
MAX_LOST: Final = 100  # places drawn at which messages were not delivered: of more, every second one, and so on
CHANGE_PERIOD_NS: Final = NS_PER_S  # a scene is drawn no more often than this because the link has changed
LOST_PERIOD_NS: Final = 10 * NS_PER_S  # and than this because messages were not delivered

_KEEP_IN: Final = Color(r=0.2, g=0.8, b=0.35, a=0.9)
_KEEP_OUT: Final = Color(r=0.9, g=0.2, b=0.2, a=0.9)
_WHITE: Final = Color(r=1, g=1, b=1, a=1)
_LINE_M: Final = 0.06
_CROSS_M: Final = 0.12
_TEXT_HEIGHT_M: Final = 1.0  # above the robot's root
_HOME: Final = {
    EventKind.RETURN_STARTED: Standing.TARGET,
    EventKind.HOME_REACHED: Standing.REACHED,
    EventKind.PLAN_FAILED: Standing.MISSED,
    EventKind.FALL: Standing.MISSED,
    EventKind.LEG_STARTED: Standing.PENDING,
}


class Surroundings:
    """Follows what is around the robot in one flight; what it keeps is bounded."""

    def __init__(self, setting: MissionSetting, root: str) -> None:
        """Know what the mission has fixed, and the robot's body `root`, above which the link's state is written."""
        self._setting, self._root = setting, root
        self._zones = tuple(_zones(setting.zones))
        self._home = Standing.PENDING
        self._has_returned = False
        self._lost: list[tuple[float, float]] = []
        self._stride, self._counts = 1, {"up": 0, "down": 0}
        self._link_state = ""  # the link by the robot's rule; empty before it was lost
        self._place = (0.0, 0.0)
        self._drawn_ns = 0
        self._contact_change_ns: int | None = -1
        self._is_changed = self._has_lost = False

    def entities(self, time_ns: int) -> Iterator[SceneEntity]:
        """Yield all that is to be drawn at a time [ns]."""
        self._drawn_ns, self._is_changed, self._has_lost = time_ns, False, False
        yield from self._zones
        home = self._setting.home_to_show(has_returned=self._has_returned)
        if home is not None:
            yield region("home", home, self._home, home.name)
        lines = [*self._contact(time_ns), *filter(None, [self._link_state]), *self._undelivered()]
        if lines:
            link = SceneEntity(id="link", frame_id=self._root)
            link.texts.append(_text((0.0, 0.0, _TEXT_HEIGHT_M), "\n".join(lines)))
            yield link
        if self._lost:
            size = Vector3(x=_CROSS_M, y=_CROSS_M, z=_CROSS_M)
            spheres = [SpherePrimitive(pose=pose((x, y, 0.0)), size=size, color=_KEEP_OUT) for x, y in self._lost]
            yield SceneEntity(id="not delivered", frame_id=WORLD, spheres=spheres)

    def happened(self, event: Event) -> bool:
        """Take an event; return whether the scene has to be drawn."""
        if event.kind is EventKind.LINK_LOST:
            self._link_state, self._is_changed = f"link lost on board at {seconds(event.time_ns):.2f} s", True
        elif event.kind is EventKind.LINK_RESTORED:
            self._link_state, self._is_changed = "link restored", True
        home = _HOME.get(event.kind)
        if event.kind is EventKind.RETURN_STARTED or (home is not None and self._home is Standing.TARGET):
            self._has_returned, self._home = True, home or Standing.TARGET
            return True
        is_over = event.kind is EventKind.MISSION_ENDED and (self._is_changed or self._has_lost)
        return is_over or self.is_due(event.time_ns)

    def lost(self, record: LinkRecord) -> None:
        """Take a message that was lost, duplicated or queued."""
        if record.outcome in NOT_DELIVERED and record.direction in self._counts:
            count = sum(self._counts.values())
            self._counts[record.direction] += 1
            if count % self._stride == 0:
                self._lost.append(self._place)
            if len(self._lost) > MAX_LOST:
                del self._lost[1::2]
                self._stride *= 2
            self._has_lost = True

    def moved(self, state: State) -> bool:
        """Take where the robot is; return whether the scene has to be drawn."""
        self._place = (float(state.qpos[0]), float(state.qpos[1]))
        return self.is_due(state.time_ns)

    def is_due(self, now_ns: int) -> bool:
        """Return whether the link has changed since the last scene so much, or so long ago, that a new one is due."""
        change_ns = self._contact_change_ns
        is_changed = self._is_changed or (change_ns is not None and 0 <= change_ns <= now_ns)
        since_ns = now_ns - self._drawn_ns
        return (is_changed and since_ns >= CHANGE_PERIOD_NS) or (self._has_lost and since_ns >= LOST_PERIOD_NS)

    def _contact(self, now_ns: int) -> Iterator[str]:
        """Yield how the link is each way, where it has windows, and remember when that changes."""
        ways = [(way, windows) for way, windows in self._setting.ways.items() if windows is not None]
        changes = [change_ns for _, windows in ways if (change_ns := windows.change_ns(now_ns)) is not None]
        self._contact_change_ns = min(changes, default=None)
        yield from (f"link {way}: {windows.state_text(now_ns)}" for way, windows in ways)

    def _undelivered(self) -> Iterator[str]:
        if any(self._counts.values()):
            yield f"not delivered: {', '.join(f'{count} {way}' for way, count in self._counts.items() if count)}"


def _zones(zones: Sequence[Zone]) -> Iterator[SceneEntity]:
    """Yield the outlines of zones with their names; of more than MAX_CORNERS corners some are left out."""
    for number, zone in enumerate(zones):
        stride = -(-len(zone.outline_m) * len(zones) // MAX_CORNERS)
        corners = zone.outline_m[:: max(1, stride)]
        line = LinePrimitive(
            type=LinePrimitive.LINE_LOOP,
            pose=pose((0.0, 0.0, 0.0)),
            thickness=_LINE_M,
            points=[Point3(x=x, y=y, z=_LINE_M) for x, y in corners],
            color=_KEEP_IN if zone.keep_in else _KEEP_OUT,
        )
        x, y = (sum(corner[axis] for corner in corners) / len(corners) for axis in (0, 1))
        entity = SceneEntity(id=f"zone {number}", frame_id=WORLD, lines=[line])
        entity.texts.append(_text((x, y, LABEL_HEIGHT_M), zone.label))
        yield entity


def _text(place: tuple[float, float, float], text: str) -> TextPrimitive:
    return TextPrimitive(pose=pose(place), billboard=True, font_size=0.3, color=_WHITE, text=text)
