"""What travels the link beside commands, acknowledgements and telemetry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BodyFrame:
    """The state of the robot's body at a control step, on its way down."""

    step: int
    qpos: FloatArray  # (nq,) [m, quaternion w x y z, rad]
    qvel: FloatArray  # (nv,) [m/s, rad/s]
    issued_ns: int
    received_ns: int


@dataclass(frozen=True, slots=True)
class ControlFrame:
    """An action, on its way up."""

    step: int  # whose state it was computed from
    values: FloatArray  # (nu,) as a fraction of the motors' full torque
    issued_ns: int
    received_ns: int


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """A sign of life from the ground, on its way up."""

    frame: int
    issued_ns: int
    received_ns: int
