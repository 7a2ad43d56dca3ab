"""The robot's motion: where its bodies are, how its root moves, how its joints stand.

This runs for every second control step of a flight, so each message is built once and filled again.
"""

from __future__ import annotations

from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointState_pb2 import JointState
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Odometry_pb2 import Odometry
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from waypointctl.log.foxglove.geometry import pose, rotate_back
from waypointctl.log.kinematics import WORLD, Kinematics
from waypointctl.log.messages import State
from waypointctl.units import NS_PER_S


def _transform(body: str) -> FrameTransform:
    return FrameTransform(
        timestamp=Timestamp(),
        parent_frame_id=WORLD,
        child_frame_id=body,
        translation=Vector3(),
        rotation=Quaternion(),
    )


class Motion:
    """Translates states of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        """Build the messages that every state fills."""
        self._kinematics = kinematics
        self._tf = FrameTransforms(transforms=[_transform(body) for body in kinematics.body_names])
        self._frames = [(it.timestamp, it.translation, it.rotation) for it in self._tf.transforms]
        self._odometry = Odometry(
            timestamp=Timestamp(),
            frame_id=WORLD,
            body_frame_id=kinematics.body_names[0],
            pose=pose((0.0, 0.0, 0.0)),
            linear_velocity=Vector3(),
            angular_velocity=Vector3(),
        )
        self._joints = JointStates(
            timestamp=Timestamp(), joints=[JointState(name=name) for name in kinematics.joint_names]
        )
        self._joint_list = list(self._joints.joints)

    def transforms(self, state: State) -> bytes:
        """Return foxglove.FrameTransforms: every body's pose in the world, so that no chain can break."""
        whole, nanos = divmod(state.time_ns, NS_PER_S)
        positions, quaternions = self._kinematics.poses(state.qpos)
        rows = zip(self._frames, positions.tolist(), quaternions.tolist(), strict=True)
        for (stamp, translation, rotation), (x, y, z), (qw, qx, qy, qz) in rows:
            stamp.seconds = whole
            stamp.nanos = nanos
            translation.x = x
            translation.y = y
            translation.z = z
            rotation.x = qx
            rotation.y = qy
            rotation.z = qz
            rotation.w = qw
        return self._tf.SerializeToString()

    def odometry(self, state: State) -> bytes:
        """Return foxglove.Odometry of the root: its pose in the world, its velocities in its own frame."""
        it = self._odometry
        _stamp(it.timestamp, state.time_ns)
        x, y, z, *quaternion = state.qpos[:7].tolist()
        _set_vector(it.pose.position, x, y, z)
        orientation = it.pose.orientation
        orientation.w, orientation.x, orientation.y, orientation.z = quaternion
        velocity = state.qvel[:6].tolist()
        _set_vector(it.linear_velocity, *rotate_back(quaternion, velocity[:3]))
        _set_vector(it.angular_velocity, *velocity[3:])
        return it.SerializeToString()

    def joints(self, state: State) -> bytes:
        """Return foxglove.JointStates: position and speed of every joint behind the root's free joint."""
        _stamp(self._joints.timestamp, state.time_ns)
        rows = zip(self._joint_list, state.qpos[7:].tolist(), state.qvel[6:].tolist(), strict=True)
        for joint, position, velocity in rows:
            joint.position = position
            joint.velocity = velocity
        return self._joints.SerializeToString()


def _stamp(timestamp: Timestamp, time_ns: int) -> None:
    timestamp.seconds, timestamp.nanos = divmod(time_ns, NS_PER_S)


def _set_vector(vector: Vector3, x: float, y: float, z: float) -> None:
    vector.x = x
    vector.y = y
    vector.z = z
