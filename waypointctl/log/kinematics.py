"""What the viewers' 3D scene needs to know of a robot; the simulation implements it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol, TypeAlias

from waypointctl.log.messages import FloatArray

GeomKind: TypeAlias = Literal["sphere", "capsule", "box", "plane"]

WORLD = "world"


@dataclass(frozen=True, slots=True)
class Geom:
    """A shape fixed to a body, in MuJoCo's terms (https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-geom)."""

    body: str  # one of the robot's bodies, or WORLD
    kind: GeomKind
    position: tuple[float, float, float]  # [m] in the body's frame
    quaternion: tuple[float, float, float, float]  # w x y z in the body's frame
    size: tuple[float, float, float]  # [m] sphere: radius; capsule: radius, half length; box, plane: half sides
    rgba: tuple[float, float, float, float]  # 0 to 1


class Kinematics(Protocol):
    """Where a robot's bodies are. Its root is a free joint: qpos and qvel begin with its 7 and 6 numbers."""

    @property
    def body_names(self) -> tuple[str, ...]:
        """The robot's bodies, the root first, without the world."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The hinge and slide joints, in the order of qpos[7:] and qvel[6:]."""

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """What is to be drawn."""

    def poses(self, qpos: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bodies' positions (nbody, 3) [m] and quaternions (nbody, 4) w x y z in the world at qpos (nq,)."""
