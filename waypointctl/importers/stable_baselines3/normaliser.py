"""The observations' mean and variance out of the file that stable-baselines3's VecNormalize saves."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import PolicyError
from waypointctl.importers.stable_baselines3.archive import read_limited
from waypointctl.importers.stable_baselines3.inert_pickle import Inert, array_of, read_inert

FloatArray = NDArray[np.float64]

_STATISTICS: Final = "RunningMeanStd"
_LARGEST: Final = 1e38  # what the exported network computes in goes little beyond
_HINT: Final = "Give the file that VecNormalize.save() wrote beside the model."


@dataclass(frozen=True, slots=True)
class Normaliser:
    """`clip((x - mean) / sqrt(variance + epsilon), -clip, clip)` for observations x.

    Attributes:
        mean: (k,) float64.
        variance: (k,) float64.
        count: how many observations they come from.
        clip: bound of the normalised observation; infinity is none.
        epsilon: added to the variance.
        sha256: of the file, "" where there is none.
    """

    mean: FloatArray
    variance: FloatArray
    count: float
    clip: float
    epsilon: float
    sha256: str = ""

    @classmethod
    def identity(cls, size: int) -> Normaliser:
        """Return the normaliser that leaves `size` float32 numbers as they are."""
        return cls(np.zeros(size), np.ones(size), 0.0, float("inf"), 1e-12)

    def apply(self, observation: FloatArray) -> FloatArray:
        """Return the normalised observations (n, k), computed as VecNormalize does."""
        scaled = (observation - self.mean) / np.sqrt(self.variance + self.epsilon)
        return np.asarray(np.clip(scaled, -self.clip, self.clip))


def read_normaliser(path: Path, size: int) -> Normaliser:
    """Read a VecNormalize file for observations of `size` numbers; nothing in it is executed.

    Raises:
        PolicyError: it cannot be read, is something else, or is for observations of another size.
    """
    content = read_limited(path)
    try:
        normaliser = _normaliser(read_inert(content), hashlib.sha256(content).hexdigest(), size)
    except (ValueError, TypeError, OverflowError) as error:  # the latter: an array or an endless number for a number
        raise PolicyError(f"not a file of VecNormalize: {error}", where=str(path), hint=_HINT) from error
    if normaliser.mean.shape != (size,):
        problem = f"it normalises observations of shape {normaliser.mean.shape}; the model takes {size} numbers"
        raise PolicyError(problem, where=str(path), hint=_HINT)
    return normaliser


def _normaliser(saved: object, sha256: str, size: int) -> Normaliser:
    if not (isinstance(saved, Inert) and isinstance(saved.state, dict)):
        raise ValueError("it holds another object")
    state: dict[str, Any] = saved.state
    if state.get("norm_obs") is False:
        return Normaliser.identity(size)
    statistics = state.get("obs_rms")
    if not (isinstance(statistics, Inert) and statistics.origin.endswith(_STATISTICS)):
        raise ValueError("it has no mean and variance of observations that are one array")
    held = statistics.state
    if not isinstance(held, dict):
        raise ValueError("its mean and variance are missing")
    mean, variance = array_of(held.get("mean")), array_of(held.get("var"))
    count, clip, epsilon = (
        float(array_of(value)) for value in (held.get("count"), state.get("clip_obs"), state.get("epsilon"))
    )
    held_by_float32 = all(np.all(np.abs(each) < _LARGEST) for each in (mean, variance, epsilon))
    if not (
        held_by_float32
        and np.isfinite(count)
        and variance.shape == mean.shape
        and (variance >= 0).all()
        and clip > 0
        and epsilon > 0
    ):
        raise ValueError("its mean, variance, clip_obs or epsilon is not what it can be")
    return Normaliser(mean, variance, count, clip, epsilon, sha256)
