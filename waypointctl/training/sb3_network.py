"""The deterministic part of a stable-baselines3 policy: its layers, and the policy itself to compare with."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, cast

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.sac.policies import SACPolicy
from stable_baselines3.td3.policies import TD3Policy
from torch import nn

from waypointctl.errors import PolicyError
from waypointctl.training.algorithms.onnx_export import Activation, Layer
from waypointctl.training.algorithms.ppo_learner import ACTIVATIONS
from waypointctl.training.sb3_archive import Sb3Archive
from waypointctl.training.sb3_tensors import Array

ACTOR_CRITIC: Final = "stable_baselines3.common.policies.ActorCriticPolicy"
SAC: Final = "stable_baselines3.sac.policies.SACPolicy"
TD3: Final = "stable_baselines3.td3.policies.TD3Policy"

# A setting that only this algorithm has. The .zip does not name the algorithm.
_SIGNS: Final = (("clip_range", "PPO"), ("cg_max_steps", "TRPO"), ("target_entropy", "SAC"), ("policy_delay", "TD3"))
_ACTORS: Final = {  # the parts of the network that an observation passes on its way to an action
    ACTOR_CRITIC: ("mlp_extractor.policy_net", "action_net"),
    SAC: ("actor.latent_pi", "actor.mu"),
    TD3: ("actor.mu",),
}
_KINDS: Final = {ACTOR_CRITIC: "the MlpPolicy of PPO and A2C", SAC: "of SAC", TD3: "of TD3"}


@dataclass(frozen=True, slots=True)
class Sb3Network:
    """What a saved policy computes.

    Attributes:
        algorithm: that trained it: PPO, A2C, SAC, ...
        layers: weight (out, in) and bias (out,) of each linear layer.
        activation: between them.
        squash: whether tanh follows the last.
        policy: stable-baselines3's own, with the same weights.
    """

    algorithm: str
    layers: tuple[Layer, ...]
    activation: Activation
    squash: bool
    policy: BasePolicy

    @property
    def hidden_sizes(self) -> tuple[int, ...]:
        """Outputs of each layer but the last."""
        return tuple(bias.size for _, bias in self.layers[:-1])


def build_network(archive: Sb3Archive, inputs: int, outputs: int) -> Sb3Network:
    """Make the policy of a saved model for observations of `inputs` numbers and actions of `outputs` in [-1, 1].

    stable-baselines3's own class is filled with the tensors, each of which has to have its place there.

    Raises:
        PolicyError: it is another kind of policy, or it is of other sizes.
    """
    where = str(archive.path)
    _refuse_other_kind(archive, where)
    _refuse_other_actions(archive, where)
    activation = _activation(archive, where)
    _refuse_unconnected(archive, inputs, outputs, where)
    try:
        policy, heads = _policy(archive, activation, inputs, outputs)
        policy.load_state_dict({name: torch.from_numpy(array) for name, array in archive.tensors.items()})
    except Exception as error:  # stable-baselines3 and torch raise many kinds for settings that do not fit together
        raise _no_perceptron(_first_fault(error), where) from error
    policy.set_training_mode(False)
    linear = [module for head in heads for module in head.modules() if isinstance(module, nn.Linear)]
    layers = tuple((layer.weight.detach().numpy(), layer.bias.detach().numpy()) for layer in linear)
    return Sb3Network(_algorithm(archive), layers, activation, _squashes(archive), policy)


def _policy(
    archive: Sb3Archive, activation: Activation, inputs: int, outputs: int
) -> tuple[BasePolicy, list[nn.Module]]:
    """Return a fresh policy and what observations pass on their way to an action."""
    tensors, given = archive.tensors, archive.policy_kwargs
    kind = archive.policy_class
    observations = spaces.Box(-np.inf, np.inf, (inputs,), np.float32)
    actions = spaces.Box(-1.0, 1.0, (outputs,), np.float32)
    hidden = [size for part in _ACTORS[kind] for size in _sizes(tensors, part)][:-1]
    function = ACTIVATIONS[activation]
    if kind == ACTOR_CRITIC:
        flags = {name: given[name] for name in ("full_std", "use_expln", "squash_output") if name in given}
        on_policy = ActorCriticPolicy(
            observations,
            actions,
            lambda _: 0.0,
            net_arch={"pi": hidden, "vf": _sizes(tensors, "mlp_extractor.value_net")},
            activation_fn=function,
            use_sde=archive.settings.get("use_sde") is True,
            **flags,
        )
        return on_policy, [on_policy.mlp_extractor.policy_net, on_policy.action_net]
    critics = _critics(tensors)
    off_policy = (SACPolicy if kind == SAC else TD3Policy)(
        observations,
        actions,
        lambda _: 0.0,
        net_arch={"pi": hidden, "qf": _sizes(tensors, "critic.qf0")[:-1]},
        activation_fn=function,
        n_critics=len(critics),
    )
    parts = ("latent_pi", "mu") if kind == SAC else ("mu",)
    return off_policy, [off_policy.actor.get_submodule(part) for part in parts]


def _sizes(tensors: Mapping[str, Array], name: str) -> list[int]:
    """Return the outputs of each linear layer of a part of the network."""
    return [weight.shape[0] for weight in _weights(tensors, name)]


def _weights(tensors: Mapping[str, Array], name: str) -> list[Array]:
    """Return the weights of each linear layer of a part of the network: "name.0.weight", ..., or "name.weight"."""
    pattern = re.compile(rf"{re.escape(name)}(?:\.([0-9]{{1,9}}))?\.weight")
    found = [(int(match[1] or 0), tensor) for key, tensor in tensors.items() if (match := pattern.fullmatch(key))]
    return [tensor for _, tensor in sorted(found, key=lambda each: each[0]) if tensor.ndim == 2]


def _critics(tensors: Mapping[str, Array]) -> set[str]:
    return {name.split(".")[1] for name in tensors if name.startswith("critic.qf")}


def _squashes(archive: Sb3Archive) -> bool:
    return archive.policy_class != ACTOR_CRITIC or archive.policy_kwargs.get("squash_output") is True


def _algorithm(archive: Sb3Archive) -> str:
    return next((name for sign, name in _SIGNS if sign in archive.settings), "A2C")


def _activation(archive: Sb3Archive, where: str) -> Activation:
    default = "tanh" if archive.policy_class == ACTOR_CRITIC else "relu"
    given = archive.policy_kwargs.get("activation_fn")
    if given is None:
        return cast(Activation, default)
    name = re.fullmatch(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>", str(given))
    if name is None or name[1].lower() not in ACTIVATIONS:
        problem = f"its activation is {name[1] if name else given}; a policy's is ELU, Tanh or ReLU"
        raise PolicyError(problem, where=where, hint="Train it again with one of these.")
    return cast(Activation, name[1].lower())


def _refuse_other_kind(archive: Sb3Archive, where: str) -> None:
    kind = archive.policy_class
    if kind not in _KINDS:
        allowed = ", ".join(f"{name.rpartition('.')[2]} ({whose})" for name, whose in _KINDS.items())
        raise PolicyError(f"its policy is {kind}; what can be imported: {allowed}", where=where)
    extractor = archive.policy_kwargs.get("features_extractor_class")
    if extractor is not None and not str(extractor).endswith(".FlattenExtractor'>"):
        raise PolicyError(f"its features extractor is {extractor}; only FlattenExtractor can be imported", where=where)
    if kind != ACTOR_CRITIC and archive.settings.get("use_sde") is True:
        problem = "it explores with gSDE (use_sde), whose clipped mean of SAC and TD3 is not supported"
        raise PolicyError(problem, where=where, hint="Train it again without use_sde, or with PPO.")


def _refuse_other_actions(archive: Sb3Archive, where: str) -> None:
    space: Mapping[str, Any] = archive.described("action_space")
    for name, bound in (("low", -1.0), ("high", 1.0)):
        text = str(space.get(name, "missing")).strip("[]")
        try:
            fits = all(float(number) == bound for number in text.split())
        except ValueError:
            fits = False
        if not fits or not text.split():
            problem = f"the {name} of its actions is {space.get(name, 'not said')}; a policy's actions are in [-1, 1]"
            raise PolicyError(problem, where=where, hint="Train it again with actions in [-1, 1].")


def _refuse_unconnected(archive: Sb3Archive, inputs: int, outputs: int, where: str) -> None:
    """Refuse layers that do not fit each other, before a policy is made with room for all that they could be."""
    tensors, kind = archive.tensors, archive.policy_class
    actor = [weight for part in _ACTORS[kind] for weight in _weights(tensors, part)]
    if not actor:
        raise _no_perceptron("it has no layers to act with", where)
    found = (actor[0].shape[1], actor[-1].shape[0])
    if found != (inputs, outputs):
        problem = (
            f"its network maps {found[0]} observations to {found[1]} actions, not {inputs} to {outputs} as the robot "
            "and the observation layout that were named have them"
        )
        raise PolicyError(problem, where=where, hint="Name what it was trained on: --observation, --robot.")
    critics = [_weights(tensors, f"critic.{name}") for name in _critics(tensors)]
    if len({tuple(weight.shape for weight in critic) for critic in critics}) > 1:
        raise _no_perceptron("its critics are not of one size", where)
    for weights in (actor, _weights(tensors, "mlp_extractor.value_net"), *critics):
        for before, after in pairwise(weights):
            if after.shape[1] != before.shape[0] or not after.size:
                problem = (
                    f"size mismatch: a layer of {before.shape[0]} outputs goes before one of {after.shape[1]} inputs"
                )
                raise _no_perceptron(problem, where)


def _no_perceptron(reason: str, where: str) -> PolicyError:
    problem = f"its network is no plain multilayer perceptron: {reason}"
    return PolicyError(problem, where=where, hint="Only stable-baselines3's own MlpPolicy can be imported.")


def _first_fault(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines()] or [type(error).__name__]
    return next((line.rstrip(". ") for line in lines[1:] if line), lines[0])
