from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.flight.flying import STILL, Scripted, mission_of
from waypointctl.errors import MissionError, PolicyError
from waypointctl.flight.fly import fly
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


@pytest.mark.parametrize("action", [np.full(8, np.nan), np.zeros(7), np.zeros(8, complex)])
@pytest.mark.parametrize("autonomy", ["mission", "joint"])
def test_an_action_that_is_none_is_refused(action: np.ndarray, autonomy: str) -> None:
    with pytest.raises(PolicyError, match="actions"):
        fly(mission_of({"position_m": [5.0, 0.0], "timeout_s": 0.2}, autonomy=autonomy), Scripted(action))


def test_a_policy_that_is_refused_leaves_no_log(tmp_path: Path) -> None:
    policy = Scripted(STILL)
    policy.reward_weights = {"fall": -1.0}
    with pytest.raises(PolicyError):
        fly(mission_of({"position_m": [5.0, 0.0]}), policy, log=tmp_path / "a.mcap")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("seed", [-1, 2**63, 1.5, "1"])
def test_a_seed_that_no_log_could_name_is_refused(seed: int) -> None:
    with pytest.raises(MissionError):
        fly(mission_of({"position_m": [5.0, 0.0]}), Scripted(STILL), seed=seed)
