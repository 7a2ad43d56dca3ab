"""The network of a saved policy: its layers and what lies between them, checked before any of it is built."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, Literal, TypeAlias, cast, get_args

from waypointctl.errors import PolicyError
from waypointctl.importers.stable_baselines3.archive import Archive
from waypointctl.importers.stable_baselines3.tensors import Array

Activation: TypeAlias = Literal["elu", "tanh", "relu"]
Layer: TypeAlias = tuple[Array, Array]

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
class SavedNetwork:
    """What a saved policy computes."""

    algorithm: str  # that trained it: PPO, A2C, SAC,
    policy_class: str  # of stable-baselines3: ACTOR_CRITIC, SAC or TD3
    layers: tuple[Layer, ...]  # weight (out, in) and bias (out,) of each linear layer from observation to action
    activation: Activation  # between them
    squash: bool  # whether tanh follows the last
    value_sizes: tuple[int, ...]  # outputs of each layer of the value network, or of each critic but for its last
    critics: int  # number of critics; 0 of an actor-critic policy

    @property
    def hidden_sizes(self) -> tuple[int, ...]:
        """Outputs of each layer but the last."""
        return tuple(bias.size for _, bias in self.layers[:-1])


def read_network(archive: Archive, inputs: int, outputs: int) -> SavedNetwork:
    """Return the network of a saved model for observations of `inputs` numbers and `outputs` actions in [-1, 1].

    Raises:
        PolicyError: it is another kind of policy, or it is of other sizes.
    """
    where = str(archive.path)
    _refuse_other_kind(archive, where)
    _refuse_other_actions(archive, where)
    activation = _activation(archive, where)
    _refuse_unconnected(archive, inputs, outputs, where)
    tensors, kind = archive.tensors, archive.policy_class
    critics = _critics(tensors)
    is_actor_critic = kind == ACTOR_CRITIC
    value_sizes = _sizes(tensors, "mlp_extractor.value_net") if is_actor_critic else _sizes(tensors, "critic.qf0")[:-1]
    return SavedNetwork(
        algorithm=next((name for sign, name in _SIGNS if sign in archive.settings), "A2C"),
        policy_class=kind,
        layers=tuple(layer for part in _ACTORS[kind] for layer in _layers(tensors, part, where)),
        activation=activation,
        squash=not is_actor_critic or archive.policy_kwargs.get("squash_output") is True,
        value_sizes=tuple(value_sizes),
        critics=len(critics),
    )


def _sizes(tensors: Mapping[str, Array], name: str) -> list[int]:
    """Return the outputs of each linear layer of a part of the network."""
    return [weight.shape[0] for weight in _weights(tensors, name)]


def _weights(tensors: Mapping[str, Array], name: str) -> list[Array]:
    """Return the weights of each linear layer of a part of the network: "name.0.weight", ..., or "name.weight"."""
    return [tensors[key] for key in _weight_names(tensors, name)]


def _layers(tensors: Mapping[str, Array], name: str, where: str) -> list[Layer]:
    layers = []
    for key in _weight_names(tensors, name):
        bias = tensors.get(f"{key.removesuffix('weight')}bias")
        if bias is None or bias.shape != tensors[key].shape[:1]:
            raise not_a_perceptron(f"size mismatch: {key} has no bias of its size", where)
        layers.append((tensors[key], bias))
    return layers


def _weight_names(tensors: Mapping[str, Array], name: str) -> list[str]:
    pattern = re.compile(rf"{re.escape(name)}(?:\.([0-9]{{1,9}}))?\.weight")
    found = [(int(match[1] or 0), key) for key in tensors if (match := pattern.fullmatch(key))]
    return [key for _, key in sorted(found) if tensors[key].ndim == 2]


def _critics(tensors: Mapping[str, Array]) -> set[str]:
    return {name.split(".")[1] for name in tensors if name.startswith("critic.qf")}


def _activation(archive: Archive, where: str) -> Activation:
    default = "tanh" if archive.policy_class == ACTOR_CRITIC else "relu"
    given = archive.policy_kwargs.get("activation_fn")
    if given is None:
        return cast(Activation, default)
    name = re.fullmatch(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>", str(given))
    if name is None or name[1].lower() not in get_args(Activation):
        problem = f"its activation is {name[1] if name else given}; a policy's is ELU, Tanh or ReLU"
        raise PolicyError(problem, where=where, hint="Train it again with one of these.")
    return cast(Activation, name[1].lower())


def _refuse_other_kind(archive: Archive, where: str) -> None:
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


def _refuse_other_actions(archive: Archive, where: str) -> None:
    space: Mapping[str, Any] = archive.described("action_space")
    for name, bound in (("low", -1.0), ("high", 1.0)):
        text = str(space.get(name, "missing")).strip("[]")
        try:
            fits = all(float(number) == bound for number in text.split())
        except ValueError:
            fits = False
        if not fits or not text.split():
            problem = f"the {name} of its actions is {space.get(name, 'missing')}; a policy's actions are in [-1, 1]"
            raise PolicyError(problem, where=where, hint="Train it again with actions in [-1, 1].")


def _refuse_unconnected(archive: Archive, inputs: int, outputs: int, where: str) -> None:
    """Refuse layers that do not fit each other, before a policy is made with room for all that they could be."""
    tensors, kind = archive.tensors, archive.policy_class
    actor = [weight for part in _ACTORS[kind] for weight in _weights(tensors, part)]
    if not actor:
        raise not_a_perceptron("it has no layers to act with", where)
    found = (actor[0].shape[1], actor[-1].shape[0])
    if found != (inputs, outputs):
        problem = (
            f"its network maps {found[0]} observations to {found[1]} actions, not {inputs} to {outputs} as the robot "
            "and the observation layout that were named have them"
        )
        raise PolicyError(problem, where=where, hint="Name what it was trained on: --observation, --robot.")
    critics = [_weights(tensors, f"critic.{name}") for name in _critics(tensors)]
    if len({tuple(weight.shape for weight in critic) for critic in critics}) > 1:
        raise not_a_perceptron("its critics are not of one size", where)
    for weights in (actor, _weights(tensors, "mlp_extractor.value_net"), *critics):
        for before, after in pairwise(weights):
            if after.shape[1] != before.shape[0] or not after.size:
                problem = (
                    f"size mismatch: a layer of {before.shape[0]} outputs goes before one of {after.shape[1]} inputs"
                )
                raise not_a_perceptron(problem, where)


def not_a_perceptron(reason: str, where: str) -> PolicyError:
    """Return the error for a network of another shape."""
    problem = f"its network is not a plain multilayer perceptron: {reason}"
    return PolicyError(problem, where=where, hint="Only stable-baselines3's own MlpPolicy can be imported.")
