"""The oracle for everything that turns: rotation matrices, and quaternions multiplied together by hand."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def about(axis: int, angle: float) -> FloatArray:
    """Return the matrix (3, 3) of a turn about x, y or z."""
    cos, sin = math.cos(angle), math.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = cos
    matrix[i, j], matrix[j, i] = -sin, sin
    return matrix


def matrix_of(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Return the matrix of the z-y-x Euler angles: yaw, then pitch about the new y, then roll about the new x."""
    return about(2, yaw) @ about(1, pitch) @ about(0, roll)


def quaternion_of(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Return the same turn as w x y z."""
    result = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in ((2, yaw), (1, pitch), (0, roll)):
        turn = np.array([math.cos(angle / 2), 0.0, 0.0, 0.0])
        turn[1 + axis] = math.sin(angle / 2)
        result = _product(result, turn)
    return result


def _product(p: FloatArray, q: FloatArray) -> FloatArray:
    scalar = p[0] * q[0] - p[1:] @ q[1:]
    return np.array([scalar, *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])
