from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.flight.policy_fit import reward_weights
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.task.plugins import reward_term
from waypointctl.task.reward import RewardWeights

Make = Callable[..., LoadedPolicy]


def test_terms_that_a_policy_does_not_name_are_at_their_defaults(make_policy: Make, tmp_path: Path) -> None:
    policy = make_policy(tmp_path / "p", reward={"orientation_penalty": 2.0, "progress_cap_mps": math.inf})
    assert reward_weights(policy) == RewardWeights(orientation_penalty=2.0)


def test_the_term_of_a_plugin_counts_where_the_plugin_is_given(make_policy: Make, tmp_path: Path) -> None:
    policy = make_policy(tmp_path / "p", reward={"fall": 1.0, "sparkle": -2.0})
    assert reward_weights(policy) == RewardWeights(fall=1.0)
    term = reward_term(name="sparkle", unit="1")(lambda view: view.up)
    assert reward_weights(policy, [term]).plugin_terms == {"sparkle": -2.0}


def test_a_cost_below_nought_is_refused(make_policy: Make, tmp_path: Path) -> None:
    with pytest.raises(PolicyError, match=r"reward\.fall: "):
        reward_weights(make_policy(tmp_path / "p", reward={"fall": -1.0}))
