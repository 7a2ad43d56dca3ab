"""What is around the robot in /scene: zones, home, how the link is, and where messages were not delivered."""

from __future__ import annotations

import numpy as np
import pytest
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from tests.log.fake_flight import WAYPOINTS, FakeKinematics
from tests.log.test_foxglove_view import state
from waypointctl.log.foxglove.scene import Standing
from waypointctl.log.foxglove.surroundings import CHANGE_PERIOD_NS, LOST_PERIOD_NS, MAX_CORNERS, MAX_LOST
from waypointctl.log.foxglove.view import FoxgloveView
from waypointctl.log.header import ContactWindows, MissionSetting
from waypointctl.log.messages import (
    Clock,
    DeliveryOutcome,
    Event,
    EventKind,
    LinkRecord,
    Message,
    Mode,
    PlannedWaypoint,
    Severity,
    Telemetry,
)
from waypointctl.mission.onboard import Zone
from waypointctl.units import NS_PER_S

HOME = PlannedWaypoint(-1, "home", 1.0, -2.0, "radius", 0.5, NS_PER_S, 0)
PASS = ContactWindows(np.array([0]), np.array([3 * NS_PER_S]), 10 * NS_PER_S)
SITE = Zone("site", True, ((-1.0, -1.0), (5.0, -1.0), (5.0, 4.0)))
PIT = Zone("pit", False, ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)))


class Viewer:
    """Shows the last message on /scene, as one does that has just sought to a time, and counts them."""

    def __init__(self, setting: MissionSetting) -> None:
        self._view = FoxgloveView(FakeKinematics(), WAYPOINTS, setting)
        self.scenes = 0
        for frame in self._view.start():
            self._take(frame.topic, frame.data)

    def __call__(self, *messages: Message) -> dict[str, SceneEntity]:
        for message in messages:
            for frame in self._view(message):
                self._take(frame.topic, frame.data)
        return self.entities

    def _take(self, topic: str, data: bytes) -> None:
        if topic == "/scene":
            self.scenes += 1
            self.entities = {entity.id: entity for entity in SceneUpdate.FromString(data).entities}

    @property
    def link(self) -> str:
        """What is written of the link."""
        return "" if "link" not in self.entities else str(self.entities["link"].texts[0].text)


def event(time_s: float, kind: EventKind) -> Event:
    return Event(round(time_s * NS_PER_S), kind, Clock.ROBOT, Severity.INFO, "")


def lost(way: str = "down", fate: DeliveryOutcome = DeliveryOutcome.LOST) -> LinkRecord:
    return LinkRecord(0, way, "telemetry", 1, 10, 0, (), fate)


def at(time_s: float, x_m: float = 0.0) -> Message:
    moved = state(round(time_s * NS_PER_S))
    moved.qpos[0] = x_m
    return moved


def test_a_mission_without_any_of_it_has_none_in_its_scene() -> None:
    names = set(Viewer(MissionSetting(home=HOME)).entities)
    assert not {name for name in names if not name.startswith(("body", "waypoint"))}


def test_zones_are_closed_lines_on_the_ground_with_their_names_each_kind_in_its_colour() -> None:
    shown = Viewer(MissionSetting(zones=(SITE, PIT))).entities
    site, pit = (shown[f"zone {number}"] for number in (0, 1))
    for entity, zone in ((site, SITE), (pit, PIT)):
        (line,) = entity.lines
        assert line.type == LinePrimitive.LINE_LOOP
        assert [(point.x, point.y) for point in line.points] == list(zone.outline_m)
        assert entity.texts[0].text == zone.label
        assert entity.frame_locked
    assert site.lines[0].color.g > site.lines[0].color.r
    assert pit.lines[0].color.r > pit.lines[0].color.g


def test_zones_stay_in_every_scene() -> None:
    viewer = Viewer(MissionSetting(zones=(SITE,)))
    leg = Event(NS_PER_S, EventKind.LEG_STARTED, Clock.ROBOT, Severity.INFO, "", waypoint=0)
    assert "zone 0" in viewer(leg)
    assert viewer.scenes == 2


def test_a_hundred_zones_of_a_thousand_corners_each_are_thinned() -> None:
    turns = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    zone = Zone("z", True, tuple((float(np.cos(turn)), float(np.sin(turn))) for turn in turns))
    shown = Viewer(MissionSetting(zones=(zone,) * 100)).entities
    corners = [len(entity.lines[0].points) for name, entity in shown.items() if name.startswith("zone")]
    assert len(corners) == 100
    assert min(corners) >= 3
    assert sum(corners) <= MAX_CORNERS


@pytest.mark.parametrize("may_return", [False, True])
def test_home_is_there_from_the_start_where_the_robot_may_go_there_and_else_once_it_does(may_return: bool) -> None:
    viewer = Viewer(MissionSetting(home=HOME, may_return=may_return))
    assert ("home" in viewer.entities) is may_return
    home = viewer(event(2, EventKind.RETURN_STARTED))["home"]
    assert (home.cylinders[0].pose.position.x, home.cylinders[0].pose.position.y) == (1.0, -2.0)
    assert home.texts[0].text == "home"


@pytest.mark.parametrize(
    ("kind", "standing"),
    [
        (EventKind.HOME_REACHED, Standing.REACHED),
        (EventKind.PLAN_FAILED, Standing.MISSED),
        (EventKind.FALL, Standing.MISSED),
        (EventKind.LEG_STARTED, Standing.PENDING),
    ],
)
def test_home_has_the_colour_of_how_the_way_there_stands(kind: EventKind, standing: Standing) -> None:
    def color(shown: dict[str, SceneEntity]) -> tuple[float, ...]:
        rgba = shown["home"].cylinders[0].color
        return rgba.r, rgba.g, rgba.b, rgba.a

    viewer = Viewer(MissionSetting(home=HOME, may_return=True))
    assert color(viewer.entities) == Standing.PENDING.value
    assert color(viewer(event(1, kind))) == Standing.PENDING.value  # it is not on its way home
    assert color(viewer(event(2, EventKind.RETURN_STARTED))) == Standing.TARGET.value
    assert color(viewer(event(3, kind))) == standing.value


def test_contact_is_told_as_it_changes_awake_and_asleep() -> None:
    viewer = Viewer(MissionSetting(up=PASS, down=PASS))
    assert viewer.link == "link up: open until 3.00 s\nlink down: open until 3.00 s"
    viewer(at(2.9))
    assert viewer.scenes == 1
    viewer(at(3.0))
    assert viewer.link == "link up: closed until 10.00 s\nlink down: closed until 10.00 s"
    frame = Telemetry(1, Mode.IDLE, 0.0, 0.0, 0.5, 0.0, 0.0, -1, (), 0, 11 * NS_PER_S)
    viewer(frame)
    assert viewer.link.startswith("link up: open until 13.00 s")
    assert viewer.scenes == 3


def test_windows_of_a_millisecond_draw_a_scene_a_second() -> None:
    blinking = ContactWindows(np.array([0]), np.array([NS_PER_S // 1000]), NS_PER_S // 500)
    viewer = Viewer(MissionSetting(down=blinking))
    viewer(*(at(step * 0.02) for step in range(500)))
    assert viewer.scenes <= 1 + 10 * NS_PER_S // CHANGE_PERIOD_NS


def test_the_link_that_is_lost_on_board_is_told() -> None:
    viewer = Viewer(MissionSetting())
    assert viewer.link == ""
    viewer(event(5, EventKind.LINK_LOST))
    assert viewer.link == "link lost on board at 5.00 s"
    viewer(event(9, EventKind.LINK_RESTORED))
    assert viewer.link == "link restored"


def test_messages_that_were_not_delivered_are_counted_and_drawn_where_the_robot_was() -> None:
    viewer = Viewer(MissionSetting())
    viewer(
        at(1, x_m=4.0),
        lost(),
        lost("up", DeliveryOutcome.NO_CONTACT),
        lost(fate=DeliveryOutcome.DUPLICATED),
        at(2, x_m=6.0),
        lost(),
    )
    assert viewer.scenes == 1, "not at once: a link can lose hundreds a second"
    shown = viewer(at(LOST_PERIOD_NS / NS_PER_S))
    assert viewer.link == "not delivered: 1 up, 2 down"
    assert [sphere.pose.position.x for sphere in shown["not delivered"].spheres] == [4.0, 4.0, 6.0]
    viewer(lost())
    assert viewer(event(11, EventKind.MISSION_ENDED))
    assert viewer.link == "not delivered: 1 up, 3 down"


def test_a_link_that_loses_thousands_draws_few_scenes_of_bounded_size() -> None:
    viewer = Viewer(MissionSetting())
    for step in range(5000):
        viewer(at(step * 0.02, x_m=step * 0.02), lost())
    assert viewer.scenes <= 1 + 100 * NS_PER_S // LOST_PERIOD_NS
    places = [sphere.pose.position.x for sphere in viewer(at(120.0))["not delivered"].spheres]
    assert MAX_LOST / 2 - 1 <= len(places) <= MAX_LOST
    assert (places[0], places == sorted(places), places[-1] > 95.0) == (0.0, True, True)
    assert viewer.link == "not delivered: 5000 down"
