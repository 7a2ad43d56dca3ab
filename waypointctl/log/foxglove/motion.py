"""The robot's motion: where its bodies are, how its root moves, how its joints stand.

This runs for every second control step of a flight, so each message is laid out once and packed from then on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointState_pb2 import JointState
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Odometry_pb2 import Odometry
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from waypointctl.log.header import Kinematics
from waypointctl.log.messages import FloatArray, State
from waypointctl.log.steps import MOMENT, NUMBER, Template, moment
from waypointctl.sim.geometry import WORLD
from waypointctl.units import NS_PER_S

_VECTOR = Vector3(x=NUMBER, y=NUMBER, z=NUMBER)
_QUATERNION = Quaternion(x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)


class Moved(NamedTuple):
    """The viewers' messages for one state."""

    transforms: bytes  # foxglove.FrameTransforms: every body's pose in the world, so that no chain can break
    odometry: bytes  # foxglove.Odometry: the root's pose in the world, its velocities in its own frame
    joints: bytes  # foxglove.JointStates: position and speed of every joint behind the root's free joint


class Motion:
    """Translates states of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        """Lay out what every state fills."""
        self._kinematics = kinematics
        self._transforms = Template(FrameTransforms(transforms=[_transform(body) for body in kinematics.body_names]))
        self._odometry = Template(
            Odometry(
                timestamp=MOMENT,
                frame_id=WORLD,
                body_frame_id=kinematics.body_names[0],
                pose=pose((NUMBER,) * 3, (NUMBER,) * 4),
                linear_velocity=_VECTOR,
                angular_velocity=_VECTOR,
            )
        )
        joints = [JointState(name=name, position=NUMBER, velocity=NUMBER) for name in kinematics.joint_names]
        self._joints = Template(JointStates(timestamp=MOMENT, joints=joints))

    def __call__(self, state: State) -> Moved:
        """Translate a state."""
        now, qpos, qvel = moment(state.time_ns), state.qpos.tolist(), state.qvel.tolist()
        positions, quaternions = self._kinematics.poses(state.qpos)
        return Moved(
            self._transforms.pack(_transforms(now, positions, quaternions)),
            self._odometry.pack(_odometry(now, qpos[:7], qvel[:6])),
            self._joints.pack(_joints(now, qpos[7:], qvel[6:])),
        )


def _transform(body: str) -> FrameTransform:
    return FrameTransform(
        timestamp=MOMENT, parent_frame_id=WORLD, child_frame_id=body, translation=_VECTOR, rotation=_QUATERNION
    )


def _transforms(now: bytes, positions: FloatArray, quaternions: FloatArray) -> list[float | bytes]:
    values: list[float | bytes] = []
    w_last = np.concatenate((positions, quaternions[:, 1:], quaternions[:, :1]), axis=1)
    for row in w_last.tolist():
        values.append(now)
        values += row
    return values


def _odometry(now: bytes, qpos: list[float], qvel: list[float]) -> list[float | bytes]:
    x, y, z, qw, qx, qy, qz = qpos
    return [now, x, y, z, qx, qy, qz, qw, *rotate_back(qpos[3:], qvel[:3]), *qvel[3:]]


def _joints(now: bytes, positions: list[float], speeds: list[float]) -> list[float | bytes]:
    values: list[float | bytes] = [now]
    for pair in zip(positions, speeds, strict=True):
        values += pair
    return values


TRAIL_POSES: Final = 256  # a longer trail is thinned, never cut: it begins where the flight began


class Trail:
    """Collects poses; each time it is full every second one goes, and from then on half as many are taken."""

    def __init__(self) -> None:
        """Begin an empty trail."""
        self._message = PosesInFrame(timestamp=Timestamp(), frame_id=WORLD)
        self._stride = 1
        self._count = 0

    def extend(self, time_ns: int, position: Sequence[float], quaternion: Sequence[float]) -> bytes:
        """Add the pose at `position` (3,) [m], `quaternion` (4,) w x y z; return foxglove.PosesInFrame."""
        poses = self._message.poses
        if self._count % self._stride == 0:
            poses.append(pose(position, quaternion))
        self._count += 1
        if len(poses) > TRAIL_POSES:
            del poses[1::2]
            self._stride *= 2
        self._message.timestamp.CopyFrom(timestamp(time_ns))
        return self._message.SerializeToString()


Triple: TypeAlias = tuple[float, float, float]
Quadruple: TypeAlias = tuple[float, float, float, float]

UPRIGHT: Quadruple = (1.0, 0.0, 0.0, 0.0)


def timestamp(time_ns: int) -> Timestamp:
    """Return a simulation time in [ns] as protobuf's timestamp, counted from 0 as the log counts."""
    return Timestamp(seconds=time_ns // NS_PER_S, nanos=time_ns % NS_PER_S)


def pose(position: Sequence[float], quaternion: Sequence[float] = UPRIGHT) -> Pose:
    """Return the pose at `position` (3,) [m], turned by `quaternion` (4,) w x y z."""
    x, y, z = position
    qw, qx, qy, qz = quaternion
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))


def rotate(quaternion: Sequence[float], vector: Sequence[float]) -> Triple:
    """Return `vector` (3,) turned by the unit `quaternion` (4,) w x y z: v + 2 q x (q x v + w v)."""
    w, x, y, z = quaternion
    a, b, c = vector
    i, j, k = y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c
    return a + 2 * (y * k - z * j), b + 2 * (z * i - x * k), c + 2 * (x * j - y * i)


def rotate_back(quaternion: Sequence[float], vector: Sequence[float]) -> Triple:
    """Return `vector` (3,) turned by the inverse of the unit `quaternion` (4,) w x y z."""
    w, x, y, z = quaternion
    return rotate((w, -x, -y, -z), vector)
