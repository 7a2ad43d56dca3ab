from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.numpy import load_file

from tests.training.tiny import RECIPE, new_state, ppo_of, tiny_recipe
from waypointctl.policy.bundle import load_policy
from waypointctl.training.checkpoint import save_checkpoint


@pytest.mark.parametrize("activation", ["elu", "tanh", "relu"])
def test_the_bundle_has_every_weight_and_acts_as_ppos_policy_does_behind_its_normaliser(
    tmp_path: Path, activation: str
) -> None:
    network = f"network: {{hidden: [24, 16, 12], activation: {activation}}}"
    text = RECIPE.replace("network: {hidden: [16, 16]}", network)
    recipe_file = tiny_recipe(tmp_path, text.replace("minibatch: 64", "minibatch: 64, clip_observation: 2.5"))
    state = new_state(recipe_file)
    learner = ppo_of(state)
    for _ in range(2):
        learner.collect()
        learner.update()
    observations = np.random.default_rng(0).normal(scale=3.0, size=(500, 31))
    normalised = np.asarray(learner.normaliser.normalize_obs(observations.astype(np.float32)))
    assert (np.abs(normalised) == 2.5).any()
    with torch.no_grad():
        expected = learner.ppo.policy._predict(torch.as_tensor(normalised), deterministic=True).numpy()

    bundle = save_checkpoint(state, tmp_path, 1.0)
    policy = load_policy(bundle)
    np.testing.assert_allclose(policy.act(observations), expected, atol=1e-5)
    raw, _ = learner.ppo.predict(observations.astype(np.float32), deterministic=True)
    assert np.abs(policy.act(observations) - raw).max() > 0.01  # the normaliser matters

    weights = load_file(bundle / "weights.safetensors")
    for name, tensor in learner.ppo.policy.state_dict().items():
        np.testing.assert_array_equal(weights.pop(name), tensor.numpy())
    assert weights.keys() == {"normaliser.mean", "normaliser.var", "normaliser.count"}
    np.testing.assert_array_equal(weights["normaliser.mean"], learner.statistics.mean)
    np.testing.assert_array_equal(weights["normaliser.var"], learner.statistics.var)
    assert weights["normaliser.count"] == pytest.approx(16 * 17)
