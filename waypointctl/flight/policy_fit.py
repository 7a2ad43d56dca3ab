"""What a flight needs of its policy: that it was made for the robot, and the weights of its reward."""

from __future__ import annotations

from pydantic import ValidationError

from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.protocol import Policy
from waypointctl.policy.require import refuse_other_robot, require
from waypointctl.robots.robot import Robot
from waypointctl.task.observation import layout
from waypointctl.task.reward import RewardWeights


def refuse_misfit(policy: Policy, robot: Robot) -> None:
    """Refuse a policy that was not made for a robot.

    Raises:
        PolicyError: it was made for another robot, observation layout, control period or kind of action.
        InputError: there is no such observation layout.
    """
    components = layout(policy.observation_layout).components
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


def reward_weights(policy: Policy) -> RewardWeights:
    """Return the weight of each reward term, those that the policy does not name at their defaults.

    Raises:
        PolicyError: it names a term that there is not, or a weight that is not a number >= 0.
    """
    known = list(RewardWeights.model_fields)
    if unknown := [name for name in policy.reward_weights if name not in known]:
        problem = f"it was trained with the reward terms {', '.join(unknown)}, which this waypointctl does not have"
        raise PolicyError(problem, where="policy", hint=f"known terms are {', '.join(known)}; train the policy again")
    try:
        return RewardWeights.model_validate(dict(policy.reward_weights))
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        problem = f"reward.{'.'.join(map(str, fault['loc']))}: {fault['msg']}"
        raise PolicyError(problem, where="policy", hint="train the policy again") from error
