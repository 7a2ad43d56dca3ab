"""What the viewers' 3D scene needs to know of a robot; the simulation implements it."""

from __future__ import annotations

from typing import Protocol

from waypointctl.log.messages import FloatArray
from waypointctl.sim.geometry import WORLD, Geom, GeomKind

__all__ = ["WORLD", "Geom", "GeomKind", "Kinematics"]


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
