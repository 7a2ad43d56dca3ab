from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.flight.policy_fit import reward_weights
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.task.reward import RewardWeights

Make = Callable[..., LoadedPolicy]


def test_terms_that_a_policy_does_not_name_are_at_their_defaults(make_policy: Make, tmp_path: Path) -> None:
    policy = make_policy(tmp_path / "p", reward={"orientation_penalty": 2.0, "progress_cap_mps": math.inf})
    assert reward_weights(policy) == RewardWeights(orientation_penalty=2.0)


@pytest.mark.parametrize(
    ("reward", "message"),
    [
        (
            {"fall": 1.0, "sparkle": 2.0},
            r"reward terms sparkle, which .*\n  Known terms are progress, progress_cap",
        ),
        ({"fall": -1.0}, r"reward\.fall: "),
    ],
)
def test_a_policy_paid_for_something_else_is_refused(
    make_policy: Make, tmp_path: Path, reward: dict[str, float], message: str
) -> None:
    policy = make_policy(tmp_path / "p", reward=reward)
    with pytest.raises(PolicyError, match=message):
        reward_weights(policy)
