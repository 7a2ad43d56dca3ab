"""A model that stable-baselines3 saved, converted to a policy bundle. No code in its files is executed."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from safetensors.numpy import save
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.sac.policies import SACPolicy
from stable_baselines3.td3.policies import TD3Policy

from waypointctl.errors import OutputError, PolicyError
from waypointctl.evaluation.saved import remove_outdated
from waypointctl.importers.stable_baselines3.archive import Archive, Normaliser, read_archive, read_normaliser
from waypointctl.importers.stable_baselines3.network import (
    ACTOR_CRITIC,
    SAC,
    SavedNetwork,
    not_a_perceptron,
    read_network,
)
from waypointctl.paths import refuse_unwritable_folder
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.policy.manifest import (
    MANIFEST,
    ActionSpec,
    NetworkSpec,
    ObservationSpec,
    PolicyDescription,
    TrainingRecord,
)
from waypointctl.policy.write import bundle_files, copy_bundle, mlp_to_onnx
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import Robot
from waypointctl.seeding import stream
from waypointctl.task.observation import Layout, layout
from waypointctl.training.algorithms.ppo_learner import ACTIVATIONS

CHECKED: Final = 256  # random observations that the bundle and stable-baselines3 act on
TOLERANCE: Final = (
    1e-4  # between their actions: a wrong network differs far more, float32 rounding less than a tenth of this
)


@dataclass(frozen=True, slots=True)
class Imported:
    """A policy that was imported.

    Attributes:
        policy: loaded from the bundle that was written.
        archive: what it came from.
        network: as it was read.
        normaliser: as it was read; of count 0 where there is none.
        difference: the largest between its actions and stable-baselines3's own, on `CHECKED` random observations.
    """

    policy: LoadedPolicy
    archive: Archive
    network: SavedNetwork
    normaliser: Normaliser
    difference: float


def import_sb3(
    model: Path,
    out: Path,
    *,
    robot: str,
    observation: str | tuple[str, ...],
    vecnormalize: Path | None = None,
    force: bool = False,
) -> Imported:
    """Make a policy bundle of a saved model.

    What cannot be checked is what the model was trained on: it is taken to be the layout and the robot named here.

    Args:
        model: the .zip of PPO, A2C, SAC or TD3 with an MlpPolicy.
        out: the bundle's folder.
        robot: that it is for.
        observation: the layout that it was trained on, by its name or the names of its groups.
        vecnormalize: the file that VecNormalize.save() wrote; without it observations are not normalised.
        force: replace a policy that is in `out` already, and remove its evaluations.

    Raises:
        PolicyError: the model or the normaliser is not what can be imported, or does not fit the layout or the robot.
        OutputError: `out` cannot be written, or something is there already.
    """
    _refuse_replacing(out, force)
    body = load_robot(robot)
    seen = layout(observation, body)
    archive = read_archive(model)
    network = read_network(archive, seen.size, body.num_actions)
    original = build_policy(archive, network)
    normaliser = read_normaliser(vecnormalize, seen.size) if vecnormalize else Normaliser.identity(seen.size)
    onnx = mlp_to_onnx(
        network.layers,
        network.activation,
        normaliser.mean,
        normaliser.variance,
        clip=normaliser.clip,
        epsilon=normaliser.epsilon,
        squash=network.squash,
    )
    description = _description(archive, network, normaliser, seen, body, out)
    files = bundle_files(description, onnx, save(_weights(archive, normaliser)))
    policy = load_policy_bytes(files, str(out))
    difference = _difference(policy, original, normaliser, str(model))
    if not difference <= TOLERANCE:
        problem = f"the exported network's actions differ from stable-baselines3's by {difference:.2g}"
        raise PolicyError(problem, where=str(model), hint="Nothing was written; please report it with the model.")
    _write(policy, out)
    return Imported(policy, archive, network, normaliser, difference)


def build_policy(archive: Archive, network: SavedNetwork) -> BasePolicy:
    """Return stable-baselines3's own policy with the tensors of a saved model, each of which has its place there.

    Raises:
        PolicyError: the tensors or settings do not fit the policy's class.
    """
    try:
        policy = _empty_policy(archive, network)
        policy.load_state_dict({name: torch.from_numpy(array) for name, array in archive.tensors.items()})
    except Exception as error:  # stable-baselines3 and torch raise many kinds for settings that do not fit together
        lines = [line.strip() for line in str(error).splitlines()] or [type(error).__name__]
        fault = next((line.rstrip(". ") for line in lines[1:] if line), lines[0])
        raise not_a_perceptron(fault, str(archive.path)) from error
    policy.set_training_mode(False)
    return policy


def _empty_policy(archive: Archive, network: SavedNetwork) -> BasePolicy:
    (_, inputs), (outputs, _) = network.layers[0][0].shape, network.layers[-1][0].shape
    observations = spaces.Box(-np.inf, np.inf, (inputs,), np.float32)
    actions = spaces.Box(-1.0, 1.0, (outputs,), np.float32)
    hidden, value, given = list(network.hidden_sizes), list(network.value_sizes), archive.policy_kwargs
    function = ACTIVATIONS[network.activation]
    if network.policy_class == ACTOR_CRITIC:
        return ActorCriticPolicy(
            observations,
            actions,
            lambda _: 0.0,
            net_arch={"pi": hidden, "vf": value},
            activation_fn=function,
            use_sde=archive.settings.get("use_sde") is True,
            **{name: given[name] for name in ("full_std", "use_expln", "squash_output") if name in given},
        )
    return (SACPolicy if network.policy_class == SAC else TD3Policy)(
        observations,
        actions,
        lambda _: 0.0,
        net_arch={"pi": hidden, "qf": value},
        activation_fn=function,
        n_critics=network.critics,
    )


def _difference(policy: LoadedPolicy, original: BasePolicy, normaliser: Normaliser, where: str) -> float:
    """Return the largest difference between the bundle's clipped actions and stable-baselines3's predict()."""
    rng = stream(0, "sb3-import")
    spread = 3.0 * np.sqrt(normaliser.variance + normaliser.epsilon)
    drawn = normaliser.mean + spread * rng.standard_normal((CHECKED, normaliser.mean.size))
    observation = drawn.astype(np.float32).astype(np.float64)
    found = np.clip(policy.act(observation), -1.0, 1.0)
    try:
        expected, _ = original.predict(normaliser.apply(observation).astype(np.float32), deterministic=True)
    except ValueError as error:  # a spread of actions, log_std, that none can be drawn with
        reason = next(iter(str(error).splitlines()), "")
        raise PolicyError(f"stable-baselines3 itself cannot act with it: {reason}", where=where) from error
    return float(np.abs(found - expected).max())


def _weights(archive: Archive, normaliser: Normaliser) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of weights.safetensors, named as those of a policy trained here."""
    tensors = dict(archive.tensors)
    return tensors | {
        "normaliser.mean": normaliser.mean,
        "normaliser.var": normaliser.variance,
        "normaliser.count": np.array(normaliser.count),
    }


def _description(
    archive: Archive, network: SavedNetwork, normaliser: Normaliser, seen: Layout, body: Robot, out: Path
) -> PolicyDescription:
    normalised = f", with a VecNormalize file of SHA-256 {normaliser.sha256}" if normaliser.sha256 else ""
    return PolicyDescription(
        name=_text(out.resolve().name),
        robot=body.name,
        control_period_ns=body.control_period_ns,
        observation=ObservationSpec.of(seen.name, seen.groups, seen.components),
        action=ActionSpec(size=body.num_actions, meaning=body.action_meaning, limits=(-1.0, 1.0)),
        network=NetworkSpec(hidden_sizes=network.hidden_sizes, activation=network.activation),
        reward={},  # a .zip does not contain reward weights; a flight uses the defaults
        training=TrainingRecord(
            algorithm=f"{network.algorithm} (stable-baselines3, imported)",
            recipe=f"imported from {_text(archive.path.name)}{normalised}",
            recipe_sha256=archive.sha256,
            seed=archive.count("seed"),
            steps=archive.count("num_timesteps"),
            wall_time_s=0.0,
            versions={"waypointctl": version("waypointctl"), "stable-baselines3": archive.version},
        ),
    )


def _text(name: str) -> str:
    """Return a file's name as text that JSON can hold: a name can have bytes that are not text."""
    return name.encode(errors="replace").decode()


def _refuse_replacing(out: Path, force: bool) -> None:
    refuse_unwritable_folder(out)
    if not out.exists() or not any(out.iterdir()):
        return
    if not (out / MANIFEST).is_file():
        raise OutputError("already exists and is not a policy", where=str(out), hint="Name another folder.")
    if not force:
        raise OutputError(
            "is a policy already", where=str(out), hint="Name another folder, or replace it with --force."
        )


def _write(policy: LoadedPolicy, out: Path) -> None:
    remove_outdated(out, policy.sha256)
    copy_bundle(policy, out)
