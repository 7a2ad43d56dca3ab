"""The robots: their MJCF and what the rest of the house needs to know of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.sim.mjcf_audit import audited_mjcf

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot: a floating base with hinge joints, one motor a joint, in the model's order."""

    name: str
    mjcf: str  # the source as it was written; MjSpec's and MjModel's own XML drift, this does not
    model: mujoco.MjModel
    substeps: int  # physics steps in a control period
    control_period_ns: int
    joint_names: tuple[str, ...]
    joint_low: FloatArray  # (nu,) [rad]
    joint_high: FloatArray  # (nu,) [rad]
    stance: FloatArray  # (nu,) joint angles to stand at [rad]
    stance_height_m: float  # of the torso, standing
    stance_stiffness: float  # of the standing controller, fraction of full torque per [rad]
    stance_damping: float  # of the standing controller, fraction of full torque per [rad/s]
    fall_height_m: float  # a torso below this has fallen
    fall_up: float  # and so has one whose upward axis has a smaller vertical part

    @property
    def num_joints(self) -> int:
        """The number of actuated joints, nu."""
        return len(self.joint_names)

    @property
    def physics_period_s(self) -> float:
        """The physics time step in [s]."""
        return float(self.model.opt.timestep)

    def to_mjb(self) -> bytes:
        """Return the compiled model as MuJoCo's binary format, which loads back exactly."""
        return _mjb(self.model)


@dataclass(frozen=True)
class _Spec:
    """What a robot's MJCF does not say."""

    asset: str
    substeps: int
    stance_deg: tuple[float, ...]
    stance_height_m: float
    stance_stiffness: float
    stance_damping: float
    fall_height_m: float
    fall_up: float


_SPECS: Final = {
    "ant": _Spec(
        asset="ant.xml",
        substeps=2,
        stance_deg=(0.0, 45.0) * 4,
        stance_height_m=0.49,
        stance_stiffness=1.0,
        stance_damping=0.25,
        fall_height_m=0.26,
        fall_up=0.2,
    )
}

ROBOT_NAMES: Final = tuple(_SPECS)
_SHORTEST_STEP_S: Final = 1e-5
_LONGEST_STEP_S: Final = 0.1


@cache
def load_robot(name: str) -> Robot:
    """Return the robot called `name`, compiled from its source.

    Raises:
        InputError: there is no such robot.
    """
    if name not in _SPECS:
        raise InputError(f"there is no robot called {name!r}; there are: {', '.join(ROBOT_NAMES)}")
    mjcf = files("waypointctl.sim").joinpath("assets", _SPECS[name].asset).read_text(encoding="utf-8")
    return _robot(name, mjcf, mujoco.MjModel.from_xml_string(mjcf))


def robot_from_source(name: str, mjcf: bytes, mjb: bytes, where: str) -> Robot:
    """Return the robot called `name` with the model that a log carries.

    The model is compiled from its source, once that has been looked at; MuJoCo never reads the compiled one, whose
    bytes are compared.

    Args:
        name: of the robot.
        mjcf: the model's source.
        mjb: the compiled model, in MuJoCo's binary format.
        where: the source's name, for messages.

    Raises:
        InputError: there is no such robot, the source cannot be used or compiles to another model, or it is not a model
            of this robot.
    """
    if name not in _SPECS:
        raise InputError(f"there is no robot called {name!r}; there are: {', '.join(ROBOT_NAMES)}")
    model = _compile(mjcf, where)
    if _mjb(model) != mjb:
        problem = f"does not compile to the compiled model beside it in MuJoCo {mujoco.__version__}"
        raise InputError(problem, where=where)
    if fault := _model_fault(_SPECS[name], model):
        raise InputError(f"is not a model of the {name}: {fault}", where=where)
    return _robot(name, mjcf.decode(), model)


def compile_mjb(mjcf: bytes, where: str) -> bytes:
    """Return what a model's source compiles to, as MuJoCo's binary format.

    Raises:
        InputError: it cannot be used, or does not compile.
    """
    return _mjb(_compile(mjcf, where))


def _compile(mjcf: bytes, where: str) -> mujoco.MjModel:
    try:
        return mujoco.MjModel.from_xml_string(audited_mjcf(mjcf, where))
    except (ValueError, mujoco.FatalError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"does not compile in MuJoCo {mujoco.__version__}: {reason}", where=where) from error


def _model_fault(spec: _Spec, model: mujoco.MjModel) -> str:
    """Return why a model is not one of a robot, nothing if it is."""
    count, joints = len(spec.stance_deg), model.actuator_trnid[:, 0]
    if model.nu != count:
        return f"it has {model.nu} motors, not {count}"
    hinges = [joint for joint in range(model.njnt) if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE]
    is_floating = model.njnt == count + 1 and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
    if not is_floating or len(hinges) != count or model.na:
        return f"it is not a floating base with {count} hinge joints"
    if any(model.actuator_trntype != mujoco.mjtTrn.mjTRN_JOINT) or sorted(joints) != hinges:
        return "each motor turns one joint, and each joint has one"
    if not _SHORTEST_STEP_S <= model.opt.timestep <= _LONGEST_STEP_S:
        return f"its time step is {model.opt.timestep:g} s, not from {_SHORTEST_STEP_S:g} to {_LONGEST_STEP_S:g} s"
    return ""


def _mjb(model: mujoco.MjModel) -> bytes:
    buffer = np.zeros(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def _robot(name: str, mjcf: str, model: mujoco.MjModel) -> Robot:
    spec = _SPECS[name]
    joints = model.actuator_trnid[:, 0]
    return Robot(
        name=name,
        mjcf=mjcf,
        model=model,
        substeps=spec.substeps,
        control_period_ns=round(spec.substeps * model.opt.timestep * 1e9),
        joint_names=tuple(model.joint(j).name for j in joints),
        joint_low=model.jnt_range[joints, 0].copy(),
        joint_high=model.jnt_range[joints, 1].copy(),
        stance=np.deg2rad(spec.stance_deg),
        stance_height_m=spec.stance_height_m,
        stance_stiffness=spec.stance_stiffness,
        stance_damping=spec.stance_damping,
        fall_height_m=spec.fall_height_m,
        fall_up=spec.fall_up,
    )
