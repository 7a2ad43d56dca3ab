"""What drives a robot: observations in, actions out."""

from __future__ import annotations

import base64
import json
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

PolicyState: TypeAlias = Mapping[str, NDArray[Any]]

_NUMBERS: Final = "fiub"  # the kinds of array that a state may have


class Policy(Protocol):
    """A map from observations to actions, for n robots at a time.

    It is deterministic: the same observations since the same state give the same actions. A class that inherits from
    this one needs `robot`, `observation_layout` and `act`; what depends on earlier observations also overrides
    `reset`, `state` and `restore`. A network in a folder is one, see `load_policy`.
    """

    @property
    def name(self) -> str:
        """What logs and evaluations call it; the name of its class unless overridden."""
        return type(self).__name__

    @property
    @abstractmethod
    def robot(self) -> str:
        """The robot that it was made for, by name."""

    @property
    @abstractmethod
    def observation_layout(self) -> str | tuple[str, ...]:
        """The observation layout that `act` expects: its name, or the names of its groups."""

    @property
    def reward_weights(self) -> Mapping[str, float]:
        """The weight of each reward term in its training, for the rewards in a log; terms left out have the default."""
        return {}

    def reset(self, mask: NDArray[np.bool_]) -> None:
        """Begin a new episode.

        Args:
            mask: (n,) True for each robot whose episode begins. Its length is the number of robots in the calls of
                `act` that follow, in the same order, if `state` has arrays.
        """
        return None

    @abstractmethod
    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return actions (n, nu), which are clipped to [-1, 1], for observations (n, k) in the layout's units."""

    def state(self) -> PolicyState:
        """Return all that the next action depends on besides the observation, by name, each array (n, ...)."""
        return {}

    def restore(self, state: PolicyState) -> None:
        """Go on from what `state` returned."""
        return None


def state_text(state: PolicyState) -> str:
    """Return a policy's state as JSON, bit for bit; empty for a policy that has none."""
    if not state:
        return ""
    described = {}
    for name, value in state.items():
        array = np.ascontiguousarray(value)
        if array.dtype.kind not in _NUMBERS:
            raise ValueError(f"the policy's state {name!r} is an array of {array.dtype}, not of numbers")
        little = array.astype(array.dtype.newbyteorder("<"))
        described[name] = [little.dtype.str, np.shape(value), base64.b64encode(little.tobytes()).decode()]
    return json.dumps(described)


def state_from(text: str) -> PolicyState:
    """Return the state that `state_text` made a text of.

    Raises:
        ValueError: it is not such a text.
    """
    if not text:
        return {}
    try:
        return {name: _array(*described) for name, described in json.loads(text).items()}
    except (TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"not the state of a policy: {error}") from error


def _array(dtype: str, shape: list[int], content: str) -> NDArray[Any]:
    kind = np.dtype(dtype)
    if kind.kind not in _NUMBERS:
        raise ValueError(f"an array of {kind}, not of numbers")
    return np.frombuffer(base64.b64decode(content, validate=True), kind).reshape(shape).copy()
