"""A robot's MJCF, compiled, with what the simulation needs to know of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, TypeAlias

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.sim.actions import ActionTransform
from waypointctl.sim.mjcf_audit import AuditedMjcf

FloatArray = NDArray[np.float64]
Servo: TypeAlias = Literal["motor", "position", "velocity", "other"]  # how an actuator interprets its control

_SHORTEST_STEP_S: Final = 1e-5
_LONGEST_STEP_S: Final = 0.1
_NAMED_JOINTS: Final = 20  # in a message


@dataclass(frozen=True, slots=True)
class CameraMount:
    """Where the robot's camera is. It is level however the base rolls and pitches, as one on gimbals.

    Attributes:
        position_m: (3,) from the origin of the base: ahead, to the left, up [m], in a frame that turns with the yaw.
        pitch_deg: below 0 it looks down.
    """

    position_m: tuple[float, float, float]
    pitch_deg: float


@dataclass(frozen=True, eq=False, kw_only=True)
class RobotModel:
    """A floating base with hinge joints, some of which have an actuator; joints are in the order of the MJCF.

    qpos is the base's position (3) [m] and quaternion w x y z (4), then the joint angles (nj) [rad]; qvel is the base's
    velocity (3) [m/s] and angular velocity in its own frame (3) [rad/s], then the joint speeds (nj) [rad/s].
    """

    name: str  # of the robot
    source: AuditedMjcf  # the MJCF that the model was compiled from
    model: mujoco.MjModel  # MuJoCo's model
    substeps: int  # physics steps in a control period
    actions: ActionTransform  # what the actuators are given for an action
    camera: CameraMount  # where the robot's camera is

    @cached_property
    def base(self) -> str:
        """The name of the body that floats."""
        return str(self.model.body(1).name)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """The joints, in the order of qpos[7:] and qvel[6:]."""
        return joint_names_of(self.model)

    @cached_property
    def actuated(self) -> NDArray[np.intp]:
        """(nu,) the joint of each actuator, as an index of `joint_names`, in the order of the actions."""
        return np.asarray(self.model.actuator_trnid[:, 0] - 1, np.intp)

    @cached_property
    def num_actions(self) -> int:
        """How many actuators the robot has, nu: the size of an action."""
        return int(self.model.nu)

    @cached_property
    def joint_low(self) -> FloatArray:
        """(nj,) the least angle of each joint [rad]; -inf where it has no limit."""
        return joint_range_of(self.model)[0]

    @cached_property
    def joint_high(self) -> FloatArray:
        """(nj,) the largest angle of each joint [rad]; inf where it has no limit."""
        return joint_range_of(self.model)[1]

    @cached_property
    def physics_period_s(self) -> float:
        """The physics time step [s]."""
        return float(self.model.opt.timestep)

    @cached_property
    def control_period_ns(self) -> int:
        """From one action to the next [ns]."""
        return round(self.substeps * float(self.model.opt.timestep) * 1e9)

    def to_mjb(self) -> bytes:
        """Return the compiled model in MuJoCo's binary format."""
        buffer = np.zeros(mujoco.mj_sizeModel(self.model), np.uint8)
        mujoco.mj_saveModel(self.model, None, buffer)
        return buffer.tobytes()


@dataclass(frozen=True, slots=True, eq=False)
class Actuators:
    """The actuators of a model, in its order."""

    joints: tuple[str, ...]  # the joint of each, by its name
    servos: tuple[Servo, ...]  # how each interprets its control
    low: FloatArray  # (nu,) the least control that each takes; -inf where the MJCF sets none
    high: FloatArray  # (nu,) the largest


def compile_model(source: AuditedMjcf, where: str) -> mujoco.MjModel:
    """Return the model of a robot's MJCF.

    Raises:
        InputError: it does not compile, or is not a floating base with named hinge joints of one actuator at most.
    """
    try:
        model = mujoco.MjModel.from_xml_string(source.xml, dict(source.assets))
    except (ValueError, mujoco.FatalError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"does not compile in MuJoCo {mujoco.__version__}: {reason}", where=where) from error
    if fault := _fault(model):
        raise InputError(f"is not a robot's model: {fault}", where=where)
    return model


def joint_names_of(model: mujoco.MjModel) -> tuple[str, ...]:
    """Return the names of the joints behind the base, in the order of qpos[7:]."""
    return tuple(model.joint(j).name for j in range(1, model.njnt))


def joint_range_of(model: mujoco.MjModel) -> tuple[FloatArray, FloatArray]:
    """Return the least and the largest angle (nj,) of each joint [rad]; infinite where it has no limit."""
    limited, (low, high) = model.jnt_limited[1:].astype(bool), model.jnt_range[1:].T
    return np.where(limited, low, -np.inf), np.where(limited, high, np.inf)


def actuators_of(model: mujoco.MjModel) -> Actuators:
    """Return what the actuators of a robot's model do."""
    limited = model.actuator_ctrllimited.astype(bool)
    return Actuators(
        joints=tuple(model.joint(j).name for j in model.actuator_trnid[:, 0]),
        servos=tuple(_servo(model, i) for i in range(model.nu)),
        low=np.where(limited, model.actuator_ctrlrange[:, 0], -np.inf),
        high=np.where(limited, model.actuator_ctrlrange[:, 1], np.inf),
    )


def missing_geoms(model: mujoco.MjModel, geoms: Sequence[str]) -> list[int]:
    """Return the places of the geoms that a model does not have."""
    return [place for place, name in enumerate(geoms) if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name) < 0]


def _servo(model: mujoco.MjModel, actuator: int) -> Servo:
    if model.actuator_gaintype[actuator] != mujoco.mjtGain.mjGAIN_FIXED:
        return "other"
    if model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE:
        return "motor"
    gain, (_, position, velocity) = model.actuator_gainprm[actuator, 0], model.actuator_biasprm[actuator, :3]
    if model.actuator_biastype[actuator] != mujoco.mjtBias.mjBIAS_AFFINE or gain <= 0:
        return "other"
    if position == -gain:
        return "position"
    return "velocity" if position == 0 and velocity == -gain else "other"


def _fault(model: mujoco.MjModel) -> str:
    """Return why a model is not that of a robot, nothing if it is."""
    if not model.njnt or model.jnt_type[0] != mujoco.mjtJoint.mjJNT_FREE:
        return "its first joint is not the <freejoint> of a base"
    if model.jnt_bodyid[0] != 1:
        return "its first body is not the base"
    if not model.body(1).name:
        return "the body of its base has no name"
    names = {model.joint(j).name: model.jnt_type[j] for j in range(1, model.njnt)}
    if len(names) != model.njnt - 1 or "" in names:
        return "a joint has no name"
    if other := [name for name, kind in names.items() if kind != mujoco.mjtJoint.mjJNT_HINGE]:
        return f"its joints are hinges behind the base, and {', '.join(other[:_NAMED_JOINTS])} is not"
    if not model.nu or model.na:
        return "it has no actuators" if not model.nu else "an actuator has a state of its own (dyntype)"
    driven = model.actuator_trnid[:, 0].tolist()
    if any(model.actuator_trntype != mujoco.mjtTrn.mjTRN_JOINT) or 0 in driven or len(set(driven)) < model.nu:
        return "each actuator drives a hinge joint, and each joint has one actuator at most"
    if not _SHORTEST_STEP_S <= model.opt.timestep <= _LONGEST_STEP_S:
        return f"its time step is {model.opt.timestep:g} s, not from {_SHORTEST_STEP_S:g} to {_LONGEST_STEP_S:g} s"
    return ""
