"""Poses between our w x y z quaternions and Foxglove's messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from waypointctl.units import NS_PER_S

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
