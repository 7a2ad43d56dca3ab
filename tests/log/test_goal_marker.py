"""The goal on a topic of its own: what a viewer shows of goals that are none of the mission's waypoints."""

from __future__ import annotations

from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from tests.log.fake_flight import WAYPOINTS, FakeKinematics
from tests.log.test_foxglove_view import many
from waypointctl.log.foxglove.view import FoxgloveView
from waypointctl.log.messages import (
    Clock,
    Command,
    CommandKind,
    CommandStage,
    Event,
    EventKind,
    Message,
    PlannedWaypoint,
    Severity,
    Stage,
)
from waypointctl.units import NS_PER_S


class Viewer:
    """Shows the last message on /goal, as one does that has just sought to a time, and counts the scenes."""

    def __init__(self, waypoints: tuple[PlannedWaypoint, ...] = WAYPOINTS) -> None:
        self._view = FoxgloveView(FakeKinematics(), waypoints)
        self.goal: tuple[float, float, str] | None = None
        self.scenes = 0
        self.largest = 0

    def __call__(self, *messages: Message) -> None:
        for message in messages:
            for frame in self._view(message):
                self.scenes += frame.topic == "/scene"
                if frame.topic == "/goal":
                    self.largest = max(self.largest, len(frame.data))
                    self._show(SceneUpdate.FromString(frame.data))

    def _show(self, update: SceneUpdate) -> None:
        assert len(update.entities) + len(update.deletions) == 1
        for entity in update.entities:
            [disc], [label] = entity.cylinders, entity.texts
            self.goal = disc.pose.position.x, disc.pose.position.y, label.text
        if update.deletions:
            self.goal = None


def place(x_m: float) -> PlannedWaypoint:
    return PlannedWaypoint(-1, "towards east", x_m, 1.0, "radius", 0.25, NS_PER_S, 0)


def go_to(number: int, waypoint: PlannedWaypoint) -> Command:
    return Command(number, CommandKind.GO_TO, (waypoint,), "abort", 0, number)


def sets_out(number: int, waypoint: int = -1, kind: EventKind = EventKind.LEG_STARTED) -> Event:
    return Event(number, kind, Clock.ROBOT, Severity.INFO, "walking", waypoint=waypoint, command_id=number)


def ends(number: int, stage: Stage, clock: Clock = Clock.ROBOT) -> CommandStage:
    return CommandStage(number, number, stage, "", clock, 1)


def test_goals_at_a_rate_draw_no_scene_and_small_messages() -> None:
    viewer = Viewer(many(100))
    for number in range(1, 101):
        viewer(go_to(number, place(number / 10)), ends(number - 1, Stage.SUPERSEDED), sets_out(number))
        assert viewer.goal == (number / 10, 1.0, "towards east")
    assert viewer.scenes == 0
    assert viewer.largest < 300


def test_waypoint_that_is_sent_again_and_again_draws_one_scene() -> None:
    viewer = Viewer()
    for number in range(1, 11):
        viewer(go_to(number, WAYPOINTS[1]), sets_out(number, waypoint=1))
    assert viewer.scenes == 1


def test_scene_follows_the_robot_from_waypoint_to_waypoint_and_back() -> None:
    viewer = Viewer()
    for number, waypoint in enumerate((0, 1, 0), start=1):
        viewer(sets_out(number, waypoint=waypoint))
    assert viewer.scenes == 3


def test_goal_is_shown_until_its_command_ends() -> None:
    for stage in (Stage.COMPLETED, Stage.FAILED, Stage.CANCELLED, Stage.EXPIRED):
        viewer = Viewer()
        viewer(go_to(7, place(2.0)), ends(7, Stage.STARTED), sets_out(7), ends(7, stage, Clock.OPERATOR))
        assert viewer.goal is not None
        viewer(ends(6, stage))
        assert viewer.goal is not None
        viewer(ends(7, stage))
        assert viewer.goal is None


def test_goal_is_gone_when_the_robot_sets_out_for_something_else() -> None:
    for event in (sets_out(8, waypoint=0), sets_out(8, kind=EventKind.RETURN_STARTED)):
        viewer = Viewer()
        viewer(go_to(7, place(2.0)), sets_out(7), ends(7, Stage.SUPERSEDED))
        assert viewer.goal is not None
        viewer(event)
        assert viewer.goal is None


def test_goal_that_waits_for_its_time_is_shown_when_the_robot_sets_out_for_it() -> None:
    viewer = Viewer()
    viewer(go_to(1, place(1.0)), go_to(2, place(2.0)), sets_out(2))
    assert viewer.goal == (2.0, 1.0, "towards east")
    viewer(ends(2, Stage.COMPLETED), sets_out(1))
    assert viewer.goal == (1.0, 1.0, "towards east")
