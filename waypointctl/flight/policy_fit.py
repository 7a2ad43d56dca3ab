"""What a flight needs of its policy: that it was made for the robot, and the weights of its reward."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from waypointctl.errors import InputError, PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.protocol import Policy
from waypointctl.policy.require import refuse_other_robot, require
from waypointctl.robots.robot import Robot
from waypointctl.task.batched import refuse_bad_action
from waypointctl.task.observation import layout
from waypointctl.task.plugins import Plugin, RewardTerm
from waypointctl.task.reward import RewardWeights

FloatArray: TypeAlias = NDArray[np.float64]


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
