from __future__ import annotations

from pathlib import Path

import pytest
import torch
from stable_baselines3 import PPO

from tests.training.tiny import RECIPE, ROLLOUT, tiny_recipe
from waypointctl.errors import RecipeError
from waypointctl.policy.bundle import load_policy
from waypointctl.training.run_folder import newest_checkpoint
from waypointctl.training.train import train


def poisoned(monkeypatch: pytest.MonkeyPatch, at_step: int, *, before_update: bool = False) -> None:
    """Let the update at a step end in a parameter that is no number, or begin with one."""
    update = PPO.train

    def poisoned_update(ppo: PPO) -> None:
        if not before_update:
            update(ppo)
        if ppo.num_timesteps == at_step:
            with torch.no_grad():
                next(ppo.policy.action_net.parameters())[0, 0] = torch.nan
        if before_update:
            update(ppo)

    monkeypatch.setattr(PPO, "train", poisoned_update)


def test_an_update_that_torch_ends_halfway_is_told_with_its_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    poisoned(monkeypatch, ROLLOUT, before_update=True)
    recipe_file, run = tiny_recipe(tmp_path), tmp_path / "run"
    with pytest.raises(RecipeError) as caught:
        train(recipe_file, run, run=run, threads=1)
    assert isinstance(caught.value.__context__, ValueError)
    assert str(caught.value).startswith(
        f"{tmp_path}/recipe.yaml: the training diverged: at step {ROLLOUT} the network has numbers that are not "
        "finite; there is no checkpoint yet\n  Start a new run with a lower"
    )


@pytest.mark.parametrize("rollouts", [4, 8])  # in the middle, and in the very last update
def test_no_checkpoint_is_taken_of_a_diverged_network_and_the_last_sound_one_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rollouts: int
) -> None:
    poisoned(monkeypatch, rollouts * ROLLOUT)
    recipe_file, run = tiny_recipe(tmp_path), tmp_path / "run"
    with pytest.raises(RecipeError, match=f"at step {rollouts * ROLLOUT} the network") as caught:
        train(recipe_file, run, run=run, threads=1)
    last = newest_checkpoint(run)
    assert last == run / "checkpoints" / f"step-{(rollouts - 2) * ROLLOUT:010d}"
    assert f"the last checkpoint is {last}" in str(caught.value)
    assert load_policy(last).manifest.training.steps == (rollouts - 2) * ROLLOUT
    assert not (run / "manifest.json").exists()


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("reward_scale: 1.0e+300", "algorithm.reward_scale: must be at most 1,000; got 1e+300"),
        ("max_gradient: 1.0e+9", "algorithm.max_gradient: must be at most 1,000; got 1e+09"),
    ],
)
def test_a_recipe_that_must_diverge_is_refused_with_its_place(tmp_path: Path, key: str, message: str) -> None:
    with pytest.raises(RecipeError) as caught:
        tiny_recipe(tmp_path, RECIPE.replace("epochs: 2}", f"epochs: 2, {key}}}"))
    assert str(caught.value).startswith(f"{tmp_path}/recipe.yaml:7:")
    assert message in str(caught.value)
