"""What viewers are told of a flight."""

from __future__ import annotations

import math

import numpy as np
import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Odometry_pb2 import Odometry
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from hypothesis import given
from hypothesis import strategies as st

from tests.log.fake_flight import STEP_NS, UPRIGHT, WAYPOINTS, FakeKinematics
from waypointctl.log.foxglove.motion import TRAIL_POSES, Trail, rotate, rotate_back
from waypointctl.log.foxglove.scene import Standing
from waypointctl.log.foxglove.view import FoxgloveView, Frame
from waypointctl.log.messages import (
    Clock,
    Command,
    CommandKind,
    Event,
    EventKind,
    Message,
    PlannedWaypoint,
    Severity,
    State,
)
from waypointctl.units import NS_PER_S

QUARTER_TURN_LEFT = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))


@pytest.fixture
def view() -> FoxgloveView:
    return FoxgloveView(FakeKinematics(), WAYPOINTS)


def state(time_ns: int, quaternion: tuple[float, ...] = UPRIGHT) -> State:
    qpos = np.array([1.0, 2.0, 0.5, *quaternion, 0.25, -0.5])
    qvel = np.array([3.0, 4.0, 5.0, 0.1, 0.2, 0.3, 7.0, 8.0])
    return State(time_ns, time_ns // STEP_NS, qpos, qvel, qvel)


def told(view: FoxgloveView, message: Message) -> dict[str, bytes]:
    frames = view(message)
    assert len({frame.topic for frame in frames}) == len(frames)
    return {frame.topic: frame.data for frame in frames}


def entities(frames: list[Frame] | dict[str, bytes]) -> dict[str, SceneEntity]:
    found = frames if isinstance(frames, dict) else {frame.topic: frame.data for frame in frames}
    return {entity.id: entity for entity in SceneUpdate.FromString(found["/scene"]).entities}


def vector(it: object) -> tuple[float, ...]:
    return tuple(getattr(it, axis) for axis in "xyz")


def matrix(quaternion: np.ndarray) -> np.ndarray:
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


parts = st.floats(-1, 1)


@given(st.tuples(parts, parts, parts, parts).filter(lambda q: np.linalg.norm(q) > 0.1), st.tuples(parts, parts, parts))
def test_rotation_is_the_rotation_matrix(quaternion: tuple[float, ...], offset: tuple[float, ...]) -> None:
    unit = np.array(quaternion) / np.linalg.norm(quaternion)
    np.testing.assert_allclose(rotate(unit.tolist(), offset), matrix(unit) @ offset, atol=1e-12)
    np.testing.assert_allclose(rotate_back(unit.tolist(), offset), matrix(unit).T @ offset, atol=1e-12)


def test_motion_is_told_at_25_hz_and_the_path_at_1_hz(view: FoxgloveView) -> None:
    topics = [list(told(view, state(step * STEP_NS))) for step in range(101)]
    moved = [step for step, names in enumerate(topics) if "/tf" in names]
    assert moved == list(range(0, 101, 2))
    assert [step for step, names in enumerate(topics) if "/odometry" in names and "/joints" in names] == moved
    assert [step for step, names in enumerate(topics) if "/path" in names] == [0, 50, 100]


@pytest.mark.parametrize("period_ns", [16_500_000, 2_000_000, 50_000_000])
def test_motion_is_never_told_faster_than_25_hz(view: FoxgloveView, period_ns: int) -> None:
    times = [step * period_ns for step in range(200) if told(view, state(step * period_ns))]
    assert len(times) > 5
    assert min(np.diff(times)) >= NS_PER_S // 25


def test_tf_holds_every_body_in_the_world(view: FoxgloveView) -> None:
    tf = FrameTransforms.FromString(told(view, state(3 * NS_PER_S + 5, QUARTER_TURN_LEFT))["/tf"])
    assert [it.child_frame_id for it in tf.transforms] == ["torso", "left", "right"]
    assert {it.parent_frame_id for it in tf.transforms} == {"world"}
    assert {(it.timestamp.seconds, it.timestamp.nanos) for it in tf.transforms} == {(3, 5)}
    assert [vector(it.translation) for it in tf.transforms] == [(1, 2, 0.5), (1, 2.2, 0.2), (1, 1.8, 0.2)]
    rotation = tf.transforms[1].rotation
    assert (rotation.w, rotation.x, rotation.y, rotation.z) == QUARTER_TURN_LEFT


def test_messages_that_are_used_again_keep_nothing_of_the_last(view: FoxgloveView) -> None:
    told(view, state(NS_PER_S + 7, QUARTER_TURN_LEFT))
    later = told(view, state(2 * NS_PER_S))
    fresh = told(FoxgloveView(FakeKinematics(), WAYPOINTS), state(2 * NS_PER_S))
    assert all(later[topic] == fresh[topic] for topic in ("/tf", "/odometry", "/joints"))


def test_odometry_turns_the_velocity_into_the_bodys_frame(view: FoxgloveView) -> None:
    odometry = Odometry.FromString(told(view, state(0, QUARTER_TURN_LEFT))["/odometry"])
    assert (odometry.frame_id, odometry.body_frame_id) == ("world", "torso")
    assert vector(odometry.pose.position) == (1, 2, 0.5)
    # Turned left, the robot's forward is the world's y: 3 m/s along x is to its right.
    assert vector(odometry.linear_velocity) == pytest.approx((4.0, -3.0, 5.0))
    assert vector(odometry.angular_velocity) == (0.1, 0.2, 0.3)


def test_joints_have_names_positions_and_speeds(view: FoxgloveView) -> None:
    joints = JointStates.FromString(told(view, state(0))["/joints"]).joints
    expected = [("left_hip", 0.25, 7.0), ("right_hip", -0.5, 8.0)]
    assert [(it.name, it.position, it.velocity) for it in joints] == expected
    assert not any(it.HasField("effort") for it in joints)


def test_scene_at_the_start_is_robot_and_waypoints(view: FoxgloveView) -> None:
    found = entities(view.start())
    assert set(found) == {"body world", "body torso", "body left", "body right", "waypoint 0", "waypoint 1"}
    assert all(entity.frame_locked for entity in found.values())
    assert {name: entity.frame_id for name, entity in found.items() if name.startswith("body")} == {
        f"body {body}": body for body in ("world", "torso", "left", "right")
    }


def test_acceptance_regions_have_their_shape_and_full_width(view: FoxgloveView) -> None:
    found = entities(view.start())
    [box] = found["waypoint 0"].cubes
    assert (box.size.x, box.size.y, box.pose.position.x, box.pose.position.y) == (1.0, 1.0, 3.0, 4.0)
    [disc] = found["waypoint 1"].cylinders
    assert (disc.size.x, disc.size.y, disc.pose.position.x, disc.pose.position.y) == (0.8, 0.8, 6.0, 4.0)
    assert [it.text for it in found["waypoint 1"].texts] == ["2 east"]


def test_shapes_have_foxgloves_full_sizes(view: FoxgloveView) -> None:
    found = entities(view.start())
    [ball] = found["body torso"].spheres
    assert vector(ball.size) == (0.5, 0.5, 0.5)
    assert vector(ball.pose.position) == (0.0, 0.0, 0.1)
    [box] = found["body right"].cubes
    assert vector(box.size) == pytest.approx((0.2, 0.4, 0.6))
    [floor] = found["body world"].cubes
    assert floor.pose.position.z + floor.size.z / 2 == 0.0


def test_capsule_is_a_cylinder_between_two_spheres(view: FoxgloveView) -> None:
    entity = entities(view.start())["body left"]
    [tube] = entity.cylinders
    assert vector(tube.size) == pytest.approx((0.16, 0.16, 0.6))
    ends = sorted(vector(ball.pose.position) for ball in entity.spheres)
    np.testing.assert_allclose(ends, [(-0.2, 0, 0), (0.4, 0, 0)], atol=1e-12)


def event(kind: EventKind, waypoint: int = -1, severity: Severity = Severity.INFO) -> Event:
    return Event(5, kind, Clock.ROBOT, severity, "so it is", waypoint=waypoint)


@pytest.mark.parametrize(
    ("kind", "standing"),
    [
        (EventKind.LEG_STARTED, Standing.TARGET),
        (EventKind.WAYPOINT_REACHED, Standing.REACHED),
        (EventKind.WAYPOINT_TIMEOUT, Standing.MISSED),
        (EventKind.WAYPOINT_SKIPPED, Standing.MISSED),
    ],
)
def test_waypoint_is_drawn_as_it_stands(view: FoxgloveView, kind: EventKind, standing: Standing) -> None:
    found = entities(told(view, event(kind, waypoint=1)))
    colors = {name: found[f"waypoint {name}"] for name in (0, 1)}
    [other], [this] = colors[0].cubes, colors[1].cylinders
    assert (this.color.r, this.color.g, this.color.b, this.color.a) == standing.value
    assert (other.color.r, other.color.g, other.color.b, other.color.a) == Standing.PENDING.value
    assert "body torso" in found  # a viewer that seeks to here knows this message alone


def test_events_are_log_lines(view: FoxgloveView) -> None:
    told_of = told(view, event(EventKind.FALL, severity=Severity.ERROR))
    assert list(told_of) == ["/log"]
    line = Log.FromString(told_of["/log"])
    assert (line.level, line.name, line.message, line.timestamp.nanos) == (Log.ERROR, "robot", "so it is", 5)


def test_command_that_says_nothing_new_is_not_drawn_again(view: FoxgloveView) -> None:
    assert view(Command(1, CommandKind.UPLOAD_PLAN, WAYPOINTS, "abort", 0, 9)) == ()


def test_command_with_another_waypoint_is_drawn(view: FoxgloveView) -> None:
    third = PlannedWaypoint(2, "west", -1.0, 0.0, "radius", 0.3, NS_PER_S, 0)
    found = told(view, Command(1, CommandKind.GO_TO, (third,), "abort", 0, 9))
    assert "waypoint 2" in entities(found)
    poses = PosesInFrame.FromString(found["/waypoints"]).poses
    assert [vector(pose.position) for pose in poses] == [(3, 4, 0), (6, 4, 0), (-1, 0, 0)]


def many(count: int) -> tuple[PlannedWaypoint, ...]:
    name = "\N{CIRCLED DIGIT ONE}" * 60  # as long as names may be
    return tuple(PlannedWaypoint(i, name, 1.5 * i, -0.1, "radius", 0.3, NS_PER_S, 0) for i in range(count))


def drawn(scene: dict[str, SceneEntity]) -> list[int]:
    return sorted(int(name.removeprefix("waypoint ")) for name in scene if name.startswith("waypoint"))


def test_up_to_a_hundred_waypoints_are_all_drawn() -> None:
    view = FoxgloveView(FakeKinematics(), many(100))
    view.start()
    for index in (0, 50, 99):
        assert drawn(entities(told(view, event(EventKind.LEG_STARTED, waypoint=index)))) == list(range(100))


def test_of_a_thousand_waypoints_those_around_the_current_one_are_drawn() -> None:
    view = FoxgloveView(FakeKinematics(), many(1000))
    # What a viewer shows that follows the flight: what it was sent, without what it was told to delete.
    shown = set(drawn(entities(view.start())))
    assert shown == set(range(100))
    for index in [*range(200), 999, 3]:
        data = told(view, event(EventKind.LEG_STARTED, waypoint=index))
        assert len(data["/scene"]) < 64 * 1024
        found = drawn(entities(data))
        deletions = SceneUpdate.FromString(data["/scene"]).deletions
        assert all((it.timestamp.seconds, it.timestamp.nanos) == (0, 6) for it in deletions)  # after the event's 5 ns
        shown = (shown - {int(it.id.removeprefix("waypoint ")) for it in deletions}) | set(found)
        begin = min(max(0, index - 25), 900)
        assert found == sorted(shown) == list(range(begin, begin + 100))


def test_trail_is_bounded_and_begins_where_the_flight_began() -> None:
    trail = Trail()
    for second in range(5 * TRAIL_POSES):
        data = trail.extend(second * NS_PER_S, (float(second), 0.0, 0.0), UPRIGHT)
        poses = PosesInFrame.FromString(data).poses
        assert len(poses) <= TRAIL_POSES
    xs = [pose.position.x for pose in poses]
    assert xs[0] == 0.0
    assert len(set(np.diff(xs))) == 1
    assert xs[-1] > 5 * TRAIL_POSES - 10
