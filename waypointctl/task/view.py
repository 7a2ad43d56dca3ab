"""N robots at one moment: pose and velocity of their bodies, and the read-only argument of groups and reward terms."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from waypointctl.robots.robot import Robot
    from waypointctl.sim.kinematics import Feet

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]

JOINT_RATE_SCALE: Final = 0.1  # Roboschool's scale for joint speeds, in observations and in the power penalty


@dataclass(frozen=True, slots=True)
class Body:
    """Pose and velocity of n robots, from their physics state.

    Attributes:
        position: (n, 3) of the base in the world frame [m].
        velocity: (n, 3) of the base in the world frame [m/s].
        rates: (n, 3) angular velocity in the body frame, as a gyroscope gives it [rad/s].
        roll: (n,) [rad], with pitch and yaw the z-y-x Euler angles of the base.
        pitch: (n,) [rad].
        yaw: (n,) [rad].
        up: (n,) vertical part of the base's upward axis: 1 upright, -1 upside down.
        joints: (n, nj) joint angles [rad].
        joint_rates: (n, nj) joint speeds [rad/s].
    """

    position: FloatArray
    velocity: FloatArray
    rates: FloatArray
    roll: FloatArray
    pitch: FloatArray
    yaw: FloatArray
    up: FloatArray
    joints: FloatArray
    joint_rates: FloatArray


def body_of(qpos: FloatArray, qvel: FloatArray) -> Body:
    """Return the body of n robots with a floating base. qpos: (n, 7 + nj), qvel: (n, 6 + nj). Arrays are views."""
    w, x, y, z = qpos[:, 3], qpos[:, 4], qpos[:, 5], qpos[:, 6]
    xx, yy = x * x, y * y
    up = 1.0 - 2.0 * (xx + yy)
    return Body(
        position=qpos[:, :3],
        velocity=qvel[:, :3],
        rates=qvel[:, 3:6],
        roll=np.arctan2(2.0 * (w * x + y * z), up),
        pitch=np.arcsin(np.minimum(np.maximum(2.0 * (w * y - z * x), -1.0), 1.0)),
        yaw=np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (yy + z * z)),
        up=up,
        joints=qpos[:, 7:],
        joint_rates=qvel[:, 6:],
    )


def fallen(body: Body, min_height_m: float, min_up: float) -> NDArray[np.bool_]:
    """Return which robots (n,) have fallen: the base is too low, or tilted too far."""
    return (body.position[:, 2] < min_height_m) | (body.up < min_up)


@dataclass(frozen=True, slots=True)
class SimulationView:
    """N robots at one moment. An observation has the state with sensor noise; a reward has the true state.

    Attributes:
        robot: its joint names, joint ranges and nominal pose.
        body: the state that the built-in groups and terms read; the properties below are read-only views of it.
        qpos: (n, nq) the true positions in MuJoCo's order.
        goals: (n, 2, 2) in the world frame [m], the current waypoint and the one after it, the same at the last.
        noise: (n, 4) drawn once per episode, each from -1 to 1.
        action: (n, nu) the latest, in [-1, 1], zeros before the first; in a reward what the motors held at the end.
        steps: (n,) control periods since the episode or the flight began; in a reward, without the one that has ended.
        approach: (n,) speed towards the current waypoint in the control period that has ended [m/s]; reward terms only.
        fell: (n,) the control period ended in a fall; reward terms only.
    """

    robot: Robot
    body: Body
    qpos: FloatArray
    goals: FloatArray
    noise: FloatArray
    action: FloatArray
    steps: NDArray[np.int64]
    approach: FloatArray | None = None
    fell: BoolArray | None = None

    def read_only(self) -> SimulationView:
        """Return the same moment with arrays that cannot be written to: a plugin does not change the simulation."""
        view: SimulationView = _all_locked(self)
        return replace(view, body=_all_locked(self.body))

    @property
    def time_s(self) -> FloatArray:
        """Since the episode or the flight began, (n,) [s]: `steps` as a time."""
        return self.steps.astype(np.float64) * (self.robot.control_period_ns / 1e9)

    @property
    def position(self) -> FloatArray:
        """Of the base in the world frame, (n, 3) [m]."""
        return _locked(self.body.position)

    @property
    def height(self) -> FloatArray:
        """Of the base above the ground, (n,) [m]."""
        return _locked(self.body.position[:, 2])

    @property
    def velocity(self) -> FloatArray:
        """Of the base in the world frame, (n, 3) [m/s]."""
        return _locked(self.body.velocity)

    @property
    def heading_velocity(self) -> FloatArray:
        """Of the base in its own yaw frame: ahead, left and up, (n, 3) [m/s]."""
        velocity = np.empty_like(self.body.velocity)
        write_heading_velocity(self.body, velocity)
        return _locked(velocity)

    @property
    def angular_velocity(self) -> FloatArray:
        """In the body frame, as a gyroscope gives it, (n, 3) [rad/s]."""
        return _locked(self.body.rates)

    @property
    def orientation(self) -> FloatArray:
        """Roll, pitch and yaw, the z-y-x Euler angles of the base, (n, 3) [rad]."""
        return _locked(np.stack([self.body.roll, self.body.pitch, self.body.yaw], axis=1))

    @property
    def up(self) -> FloatArray:
        """Vertical part of the base's upward axis, (n,): 1 upright, -1 upside down."""
        return _locked(self.body.up)

    @property
    def joint_angles(self) -> FloatArray:
        """In the order of `robot.joint_names`, (n, nj) [rad]."""
        return _locked(self.body.joints)

    @property
    def joint_speeds(self) -> FloatArray:
        """In the order of `robot.joint_names`, (n, nj) [rad/s]."""
        return _locked(self.body.joint_rates)

    @property
    def foot_heights(self) -> FloatArray:
        """Of the lowest point of each of `robot.feet` above the ground, (n, k) [m]."""
        return _locked(self._feet.heights(self.qpos))

    @property
    def contacts(self) -> BoolArray:
        """Whether each foot touches the ground, (n, k)."""
        return self.foot_heights < self._feet.margins

    @property
    def _feet(self) -> Feet:
        from waypointctl.sim.kinematics import feet_of  # the simulator, which a layout is known without

        return feet_of(self.robot, self.robot.feet)


def write_heading_velocity(body: Body, out: FloatArray) -> None:
    """Write the base's velocity in its own yaw frame: ahead, left and up, (n, 3) [m/s]."""
    cos, sin = np.cos(body.yaw), np.sin(body.yaw)
    vx, vy = body.velocity[:, 0], body.velocity[:, 1]
    out[:, 0] = cos * vx + sin * vy
    out[:, 1] = cos * vy - sin * vx
    out[:, 2] = body.velocity[:, 2]


def _all_locked(value: Any) -> Any:
    named = ((field.name, getattr(value, field.name)) for field in fields(value))
    return replace(value, **{name: _locked(part) for name, part in named if isinstance(part, np.ndarray)})


def _locked(array: FloatArray) -> FloatArray:
    view = array.view()
    view.flags.writeable = False
    return view
