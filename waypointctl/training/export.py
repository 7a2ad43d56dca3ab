"""From a training to a policy bundle."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Final

from safetensors.numpy import save

from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import ActionSpec, NetworkSpec, ObservationSpec, PolicyDescription, TrainingRecord
from waypointctl.policy.write import write_bundle
from waypointctl.task.plugins import plugin_hashes
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.state import TrainingState

PACKAGES: Final = ("waypointctl", "mujoco", "mjbatch", "numpy", "torch", "stable-baselines3")


def export_policy(state: TrainingState, recipe_file: RecipeFile, folder: Path, wall_time_s: float) -> LoadedPolicy:
    """Write the policy as it now is as a bundle in `folder`, and return it, loaded.

    Raises:
        OutputError: the folder cannot be written.
    """
    exported = state.learner.export()
    return write_bundle(folder, _description(state, recipe_file, wall_time_s), exported.onnx, save(exported.weights))


def _description(state: TrainingState, recipe_file: RecipeFile, wall_time_s: float) -> PolicyDescription:
    recipe, env = state.recipe, state.env
    names, units, scales = zip(*env.layout.components, strict=True)
    return PolicyDescription(
        name=recipe.name,
        robot=env.robot.name,
        control_period_ns=env.robot.control_period_ns,
        observation=ObservationSpec(
            layout=env.layout.name,
            groups=env.layout.groups,
            size=env.layout.size,
            names=names,
            units=units,
            scales=scales,
        ),
        action=ActionSpec(size=env.robot.num_actions, meaning=env.robot.action_meaning, limits=(-1.0, 1.0)),
        network=NetworkSpec(hidden_sizes=recipe.network.hidden, activation=recipe.network.activation),
        reward=recipe.phases[-1].reward.model_dump(),
        training=TrainingRecord(
            algorithm=state.learner.algorithm,
            recipe=recipe.name,
            recipe_sha256=recipe_file.sha256,
            seed=recipe.seed,
            steps=state.steps,
            wall_time_s=round(wall_time_s, 1),
            versions=_versions(),
            start=state.start,
        ),
        plugins=plugin_hashes(env.config.plugins),
    )


@cache
def _versions() -> dict[str, str]:
    return {package: version(package) for package in PACKAGES}
