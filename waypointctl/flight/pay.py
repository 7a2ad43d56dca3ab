"""What a policy was paid in training, as the task takes it."""

from __future__ import annotations

from dataclasses import fields

from waypointctl.errors import InputError, PolicyError
from waypointctl.policy.protocol import Policy
from waypointctl.task.reward import RewardWeights


def reward_weights(policy: Policy) -> RewardWeights:
    """Return the weight of each reward term, those that the policy does not name at their defaults.

    Raises:
        PolicyError: it names a term that there is not, or a weight that is not a number >= 0.
    """
    known = [field.name for field in fields(RewardWeights)]
    if unknown := [name for name in policy.reward_weights if name not in known]:
        problem = f"it was paid for {', '.join(unknown)}, which this waypointctl does not know"
        raise PolicyError(problem, where="policy", hint=f"known terms are {', '.join(known)}; train the policy again")
    try:
        return RewardWeights(**policy.reward_weights)
    except InputError as error:
        raise PolicyError(error.problem, where="policy", hint="train the policy again") from error
