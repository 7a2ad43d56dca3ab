"""The reward weights that a policy was trained with, as the task takes them."""

from __future__ import annotations

from pydantic import ValidationError

from waypointctl.errors import PolicyError
from waypointctl.policy.protocol import Policy
from waypointctl.task.reward import RewardWeights


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
