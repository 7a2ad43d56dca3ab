"""From a learner to a policy bundle."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import save
from torch import nn

from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import ActionSpec, NetworkSpec, ObservationSpec, PolicyDescription, TrainingRecord
from waypointctl.policy.write import write_bundle
from waypointctl.training.learner import Learner
from waypointctl.training.onnx_export import mlp_to_onnx
from waypointctl.training.recipe_file import RecipeFile

PACKAGES: Final = ("waypointctl", "mujoco", "mjbatch", "numpy", "torch", "stable-baselines3")
ACTION_MEANING: Final = "motor torque of each joint as a fraction of its maximum, in the model's actuator order"


def export_policy(learner: Learner, recipe_file: RecipeFile, folder: Path, wall_time_s: float) -> LoadedPolicy:
    """Write the policy as it now is as a bundle in `folder`, and return it, loaded.

    Raises:
        OutputError: the folder cannot be written.
    """
    statistics = learner.statistics
    onnx = mlp_to_onnx(
        _layers(learner),
        learner.recipe.network.activation,
        statistics.mean,
        statistics.var,
        clip=learner.normaliser.clip_obs,
        epsilon=learner.normaliser.epsilon,
    )
    return write_bundle(folder, _description(learner, recipe_file, wall_time_s), onnx, save(weights(learner)))


def weights(learner: Learner) -> dict[str, NDArray[np.generic]]:
    """Return everything learnt, by name: PPO's parameters and the normaliser's statistics."""
    tensors = {name: tensor.detach().cpu().numpy() for name, tensor in learner.ppo.policy.state_dict().items()}
    statistics = learner.statistics
    return tensors | {
        "normaliser.mean": statistics.mean,
        "normaliser.var": statistics.var,
        "normaliser.count": np.array(statistics.count),
    }


def _layers(learner: Learner) -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
    policy = learner.ppo.policy
    modules = [*policy.mlp_extractor.policy_net, policy.action_net]
    linear = [module for module in modules if isinstance(module, nn.Linear)]
    return [(layer.weight.detach().numpy(), layer.bias.detach().numpy()) for layer in linear]


def _description(learner: Learner, recipe_file: RecipeFile, wall_time_s: float) -> PolicyDescription:
    recipe, env = learner.recipe, learner.env
    names, units, scales = zip(*env.layout.components, strict=True)
    return PolicyDescription(
        name=recipe.name,
        robot=recipe.robot,
        control_period_ns=env.robot.control_period_ns,
        observation=ObservationSpec(
            layout=env.layout.name, size=env.layout.size, names=names, units=units, scales=scales
        ),
        action=ActionSpec(size=env.robot.num_actions, meaning=ACTION_MEANING, limits=(-1.0, 1.0)),
        network=NetworkSpec(hidden_sizes=recipe.network.hidden, activation=recipe.network.activation),
        reward=recipe.phases[-1].reward.model_dump(),
        training=TrainingRecord(
            algorithm="PPO (stable-baselines3)",
            recipe=recipe.name,
            recipe_sha256=recipe_file.sha256,
            seed=recipe.seed,
            steps=learner.steps,
            wall_time_s=round(wall_time_s, 1),
            versions={package: version(package) for package in PACKAGES},
            start=learner.start,
        ),
    )
