"""Symmetries of a robot: what a policy learns for one leg holds for the others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MOST_SYMMETRIES: Final = 48  # of a cube, the most of any body with a few legs
_DIGITS: Final = 6


@dataclass(frozen=True, eq=False)
class Symmetry:
    """A map of a robot's states and actions to those of the same motion, mirrored or turned.

    Attributes:
        name: as robot.yaml has it; of a combination the names in the order in which they are applied.
        frame: (3, 3) the orthogonal matrix that a vector in the base's frame is multiplied by.
        joints: (nj,) for each joint of the image, the joint whose angle it takes.
        signs: (nj,) 1 or -1, what that angle is multiplied by.
    """

    name: str
    frame: FloatArray
    joints: NDArray[np.intp]
    signs: FloatArray

    def of_joints(self, values: FloatArray) -> FloatArray:
        """Return the image of joint angles or speeds (n, nj)."""
        return np.asarray(values[:, self.joints] * self.signs)

    def of_vectors(self, vectors: FloatArray) -> FloatArray:
        """Return the image of vectors (n, 3) in the base's frame: places, velocities, forces."""
        return np.asarray(vectors @ self.frame.T)

    def of_rotations(self, vectors: FloatArray) -> FloatArray:
        """Return the image of angular velocities or torques (n, 3) in the base's frame, which a mirror turns round."""
        return self.of_vectors(vectors) * (1.0 if np.linalg.det(self.frame) > 0 else -1.0)

    def then(self, other: Symmetry) -> Symmetry:
        """Return this symmetry followed by another."""
        return Symmetry(
            name=f"{self.name} {other.name}",
            frame=other.frame @ self.frame,
            joints=self.joints[other.joints],
            signs=self.signs[other.joints] * other.signs,
        )

    @property
    def key(self) -> tuple[bytes, ...]:
        """What distinguishes a symmetry from others."""
        return (np.round(self.frame, _DIGITS) + 0.0).tobytes(), self.joints.tobytes(), self.signs.tobytes()


def frame_of(mirror: bool, turn_deg: float) -> FloatArray:
    """Return the matrix (3, 3) of a mirror image (y becomes -y) that is then turned to the left about z."""
    turn_rad = math.radians(turn_deg)
    cos, sin, side = math.cos(turn_rad), math.sin(turn_rad), -1.0 if mirror else 1.0
    return np.array([[cos, -sin * side, 0.0], [sin, cos * side, 0.0], [0.0, 0.0, 1.0]])


def combined(given: Sequence[Symmetry], num_joints: int) -> tuple[Symmetry, ...]:
    """Return the symmetries that some combine to: the identity first, then those given, then the others.

    Raises:
        ValueError: there are more than `MOST_SYMMETRIES`.
    """
    identity = Symmetry("identity", np.eye(3), np.arange(num_joints), np.ones(num_joints))
    found = {identity.key: identity}
    for each in given:
        found.setdefault(each.key, each)
    new = list(found.values())[1:]
    while new:
        images = [one.then(each) for one in new for each in given]
        new = []
        for image in images:
            if image.key not in found:
                found[image.key] = image
                new.append(image)
        if len(found) > MOST_SYMMETRIES:
            raise ValueError(f"they combine to more than {MOST_SYMMETRIES} symmetries")
    return tuple(found.values())
