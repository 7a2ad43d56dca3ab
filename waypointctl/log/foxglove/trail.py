"""The path walked so far, in a bounded number of poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from google.protobuf.timestamp_pb2 import Timestamp

from waypointctl.log.foxglove.geometry import pose, timestamp
from waypointctl.log.kinematics import WORLD

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
