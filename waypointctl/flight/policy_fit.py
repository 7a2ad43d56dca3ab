"""What a flight needs of its policy: that it was made for the robot, and the weights of its reward."""

from __future__ import annotations

from collections.abc import Iterable

from pydantic import ValidationError

from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.protocol import Policy
from waypointctl.policy.require import refuse_other_robot, require
from waypointctl.robots.robot import Robot
from waypointctl.task.observation import layout
from waypointctl.task.plugins import Plugin, RewardTerm
from waypointctl.task.reward import RewardWeights


def refuse_misfit(policy: Policy, robot: Robot, plugins: Iterable[Plugin] = ()) -> None:
    """Refuse a policy that was not made for a robot.

    Raises:
        PolicyError: it was made for another robot, observation layout, control period or kind of action.
        InputError: there is no such observation layout.
    """
    components = layout(policy.observation_layout, robot, plugins).components
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
