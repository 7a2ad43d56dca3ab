"""What a flight needs of its policy: that it fits the robot, its reward weights, and what the log says of it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from waypointctl.errors import InputError, LogError, PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.protocol import Policy
from waypointctl.policy.require import refuse_other_robot, require
from waypointctl.robots.robot import Robot
from waypointctl.task.batched import refuse_bad_action
from waypointctl.task.observation import layout
from waypointctl.task.plugins import Plugin, RewardTerm
from waypointctl.task.reward import RewardWeights

FloatArray: TypeAlias = NDArray[np.float64]

POLICY_CLASS: Final = "policy_class"  # of a policy that is not a bundle: the log does not carry it
REWARD_WEIGHTS: Final = "reward_weights"  # of such a policy, JSON
_WEIGHTS: Final = TypeAdapter(dict[str, float])


class PolicyNotInLog(Policy):
    """A policy that a log names and does not carry: its class, and what a replay needs besides its actions."""

    def __init__(self, metadata: Mapping[str, str], robot: Robot) -> None:
        """Read from a log's header which policy drove `robot`.

        Raises:
            LogError: its reward weights are not a mapping of names to numbers.
        """
        self.class_name = metadata.get(POLICY_CLASS, "")
        self._metadata = metadata
        self._robot = robot
        try:
            self._weights = _WEIGHTS.validate_json(metadata.get(REWARD_WEIGHTS, ""))
        except ValidationError as error:
            raise LogError(f"metadata: {REWARD_WEIGHTS}: expected a mapping of names to numbers") from error

    @property
    def name(self) -> str:
        """What the log calls it."""
        return self._metadata.get("policy", "")

    @property
    def robot(self) -> str:
        """The robot that it drove."""
        return self._robot.name

    @property
    def observation_layout(self) -> str | tuple[str, ...]:
        """Its observation layout."""
        names = tuple(self._metadata.get("observation_layout", "").split())
        return names if len(names) > 1 else "".join(names)

    @property
    def reward_weights(self) -> Mapping[str, float]:
        """The weight of each reward term."""
        return self._weights

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return zeros: its actions are not known."""
        return np.zeros((len(observation), self._robot.num_actions))


def refuse_misfit(policy: Policy, robot: Robot, plugins: Iterable[Plugin] = ()) -> None:
    """Refuse a policy that was not made for a robot.

    Raises:
        PolicyError: it was made for another robot, observation layout, control period or kind of action, or there is no
            such observation layout or group.
    """
    try:
        components = layout(policy.observation_layout, robot, plugins).components
    except InputError as error:
        raise PolicyError(error.problem, where=f"policy {policy.name!r}", hint=error.hint) from error
    if isinstance(policy, LoadedPolicy):
        require(
            policy,
            robot=robot.name,
            num_joints=robot.num_actions,
            components=components,
            control_period_ns=robot.control_period_ns,
        )
    else:
        refuse_other_robot(policy, robot.name)


def chosen_action(policy: Policy, observation: FloatArray, num_actions: int) -> FloatArray:
    """Return the policy's action (1, nu) for an observation (1, k).

    Raises:
        PolicyError: it is not numbers, has another shape, or a number that is not finite.
    """
    action = policy.act(observation)
    if isinstance(policy, LoadedPolicy):
        return action  # checked when it was loaded, and by the network
    try:
        return refuse_bad_action(action, num_actions, 1)
    except InputError as error:
        raise PolicyError(error.problem, where=f"policy {policy.name!r}", hint=error.hint) from error


def reward_weights(policy: Policy, plugins: Iterable[Plugin] = ()) -> RewardWeights:
    """Return the weight of each reward term, those that the policy does not name at their defaults.

    The terms of a plugin that is not given are left out: they change the rewards in the log, not the flight.

    Raises:
        PolicyError: a weight is not a number within its bounds.
    """
    known = {*RewardWeights.model_fields, *(one.name for one in plugins if isinstance(one, RewardTerm))}
    own = {name: weight for name, weight in policy.reward_weights.items() if name in known}
    try:
        return RewardWeights.model_validate(own)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        problem = f"reward.{'.'.join(map(str, fault['loc']))}: {fault['msg']}"
        raise PolicyError(problem, where="policy", hint="train the policy again") from error


def policy_facts(policy: Policy) -> dict[str, str]:
    """Return the hash of a bundle; of another policy its class, and what replay needs of it besides its actions."""
    if isinstance(policy, LoadedPolicy):
        return {"sha256_policy": policy.sha256}
    name = policy.class_name if isinstance(policy, PolicyNotInLog) else class_name(policy)
    return {POLICY_CLASS: name, REWARD_WEIGHTS: json.dumps(dict(policy.reward_weights))}


def class_name(value: object) -> str:
    """Return the full name of a value's class."""
    return f"{type(value).__module__}.{type(value).__qualname__}"
