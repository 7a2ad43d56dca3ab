"""Reading a model that stable-baselines3 saved, without executing any of it.

Its .zip holds the networks (policy.pth, what torch.save() wrote of the tensors) and the settings (data, JSON).
What JSON cannot hold is pickled in there, base64 under ":serialized:", with a readable description beside it
(stable_baselines3/common/save_util.py). Here the descriptions are read and the pickles are left alone.

The mean and variance of observations are in a file of their own, which VecNormalize saves.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import PolicyError
from waypointctl.importers.stable_baselines3.inert_pickle import Inert, array_of, read_inert
from waypointctl.importers.stable_baselines3.tensors import Array, opened_zip, read_part, read_tensors
from waypointctl.input_file import read_input
from waypointctl.limits import limit

LIMIT: Final = "sb3-archive"  # its name: of a file, and of what it unpacks to

MOST_COUNT: Final = 10**15  # as in a manifest
_MOST_SETTINGS: Final = 2**24  # [bytes] of the JSON
_DATA: Final = "data"
_TENSORS: Final = "policy.pth"
_VERSION: Final = "_stable_baselines3_version"
_HINT: Final = "Give the .zip that stable-baselines3's model.save() wrote."

FloatArray = NDArray[np.float64]
_STATISTICS: Final = "RunningMeanStd"
_LARGEST: Final = 1e38  # what the exported network computes in goes little beyond
_VEC_NORMALIZE_HINT: Final = "Give the file that VecNormalize.save() wrote beside the model."


@dataclass(frozen=True, slots=True)
class Archive:
    """A saved model."""

    path: Path  # of the .zip
    sha256: str  # of its bytes
    version: str  # of the stable-baselines3 that wrote it
    settings: Mapping[str, Any]  # of the algorithm, by name; what was pickled is its readable description
    tensors: Mapping[str, Array]  # of the networks, by name

    @property
    def policy_class(self) -> str:
        """The policy's class, "module.Name"; as much of it as is known."""
        described = self.described("policy_class")
        module = described.get("__module__") or "unknown"
        made = re.search(r"<function ([\w.]+)\.__init__ ", str(described.get("__init__")))
        return f"{module}.{made[1]}" if made else str(module)

    @property
    def policy_kwargs(self) -> Mapping[str, Any]:
        """What was given to the policy, classes as text such as "<class 'torch.nn.modules.activation.ReLU'>"."""
        return {name: value for name, value in self.described("policy_kwargs").items() if not name.startswith(":")}

    def described(self, name: str) -> Mapping[str, Any]:
        """Return a setting that is an object or a dict, by its items; empty if it is neither."""
        value = self.settings.get(name)
        return value if isinstance(value, dict) else {}

    def count(self, name: str) -> int:
        """Return a setting that is a whole number up to `MOST_COUNT`, 0 if it is none."""
        value = self.settings.get(name)
        return value if type(value) is int and 0 <= value <= MOST_COUNT else 0


def read_limited(path: Path) -> bytes:
    """Return a file's bytes.

    Raises:
        PolicyError: it cannot be read, or is larger than the limit.
    """
    return read_input(path, LIMIT, PolicyError)


def read_archive(path: Path) -> Archive:
    """Read a saved model; nothing in it is executed.

    Raises:
        PolicyError: it cannot be read, is not such a .zip, or policy.pth holds more than tensors.
    """
    content = read_limited(path)
    try:
        with opened_zip(content) as archive:
            settings = read_part(archive, _DATA, _MOST_SETTINGS)
            tensors = read_part(archive, _TENSORS, limit(LIMIT))
            version = read_part(archive, _VERSION, 1000) if _VERSION in archive.namelist() else b"unknown"
    except ValueError as error:
        hint = f"{_HINT} Its parts {_DATA} and {_TENSORS} are read, up to a limit (docs/limits.md)."
        raise PolicyError(str(error), where=str(path), hint=hint) from error
    return Archive(
        path,
        hashlib.sha256(content).hexdigest(),
        version.decode(errors="replace").strip()[:40] or "unknown",
        _settings(settings, f"{path}/{_DATA}"),
        _tensors(tensors, f"{path}/{_TENSORS}"),
    )


def _settings(content: bytes, where: str) -> dict[str, Any]:
    try:
        settings = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise PolicyError(f"not JSON: {error}", where=where, hint=_HINT) from error
    if not isinstance(settings, dict):
        raise PolicyError("not a JSON object", where=where, hint=_HINT)
    return settings


def _tensors(content: bytes, where: str) -> dict[str, Array]:
    try:
        return read_tensors(content, limit(LIMIT))
    except ValueError as error:
        raise PolicyError(f"{error}; nothing of it was executed", where=where, hint=_HINT) from error


@dataclass(frozen=True, slots=True)
class Normaliser:
    """`clip((x - mean) / sqrt(variance + epsilon), -clip, clip)` for observations x."""

    mean: FloatArray  # (k,) float64
    variance: FloatArray  # (k,) float64
    count: float  # how many observations they come from
    clip: float  # bound of the normalised observation; infinity is none
    epsilon: float  # added to the variance
    sha256: str = ""  # of the file, "" where there is none

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
        raise PolicyError(f"not a file of VecNormalize: {error}", where=str(path), hint=_VEC_NORMALIZE_HINT) from error
    if normaliser.mean.shape != (size,):
        problem = f"it normalises observations of shape {normaliser.mean.shape}; the model takes {size} numbers"
        raise PolicyError(problem, where=str(path), hint=_VEC_NORMALIZE_HINT)
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
