"""The shapes a robot is drawn with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

GeomKind: TypeAlias = Literal["sphere", "capsule", "ellipsoid", "cylinder", "box", "plane"]

WORLD: Final = "world"


@dataclass(frozen=True, slots=True)
class Geom:
    """A shape fixed to a body, in MuJoCo's terms (https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-geom)."""

    body: str  # one of the robot's bodies, or WORLD
    kind: GeomKind
    position: tuple[float, float, float]  # [m] in the body's frame
    quaternion: tuple[float, float, float, float]  # w x y z in the body's frame
    size: tuple[float, float, float]  # [m] radius; or radius and half length; box, plane, ellipsoid: half sides
    rgba: tuple[float, float, float, float]  # 0 to 1
