"""A robot: its compiled model, and the data of its robot.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from waypointctl.robots.description import RobotDescription
from waypointctl.robots.symmetry import Symmetry
from waypointctl.sim.model import RobotModel

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Robot(RobotModel):
    """A robot that is ready to be simulated; `load_robot` makes one.

    Attributes:
        description: robot.yaml.
        files: the files of its folder that it is made of, by their paths in there: robot.yaml, the MJCF, what that
            includes, meshes, textures.
        nominal: (nj,) the joint angles of the nominal pose [rad].
        is_servo: (nu,) whether an action is the target of a servo.
        servo_rest: (nu,) the action at which a servo holds the nominal pose, or a wheel stops; 0 for a motor.
        symmetries: the identity first; only that where robot.yaml names none.
    """

    description: RobotDescription
    files: Mapping[str, bytes]
    nominal: FloatArray
    is_servo: NDArray[np.bool_]
    servo_rest: FloatArray
    symmetries: tuple[Symmetry, ...]

    @property
    def nominal_height_m(self) -> float:
        """Height of the base's origin in the nominal pose [m]."""
        return self.description.nominal.height_m

    @property
    def min_height_m(self) -> float:
        """A robot whose base is lower has fallen [m]."""
        return self.description.termination.min_height_m

    @property
    def min_up(self) -> float:
        """A robot has fallen whose base's upward axis has a smaller vertical part."""
        return self.description.termination.min_up

    @property
    def action_meaning(self) -> str:
        """What the numbers of an action are, in words, for the manifest of a policy."""
        groups = (f"{group.kind} of {', '.join(group.joints)}" for group in self.description.actions)
        return f"{'; '.join(groups)}, in the order of the actuators"

    @property
    def feet(self) -> tuple[str, ...]:
        """The geoms that are meant to touch the ground."""
        return self.description.feet
