"""Beginning a training with another policy's weights."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load

from waypointctl.errors import RecipeError
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import WEIGHTS, StartRecord
from waypointctl.task.observation import layout
from waypointctl.training.export import weights
from waypointctl.training.learner import Learner
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.status import StartedFrom

_MEND = "Give the recipe the network and an observation of that policy's sizes, or another policy in start_from."


@dataclass(frozen=True, slots=True)
class Origin:
    """The policy that a training begins with: all that it learnt, by name as `export.weights` has it."""

    policy: LoadedPolicy
    learnt: dict[str, NDArray[np.generic]]


def load_origin(recipe_file: RecipeFile) -> Origin | None:
    """Return the policy in the recipe's `start_from`, a folder that is looked for beside the recipe; None without one.

    Raises:
        PolicyError: there is no such policy, or it is damaged.
        RecipeError: it is of other sizes than the recipe, of another activation or for another robot; or it was chosen
            with the seed that the recipe's evaluation has.
    """
    if recipe_file.recipe.start_from is None:
        return None
    folder = recipe_file.path.parent / recipe_file.recipe.start_from
    policy = load_policy(folder)
    _refuse_other_kind(policy, recipe_file)
    _refuse_chosen_by_what_is_reported(policy, recipe_file)
    try:
        return Origin(policy, load(policy.files[WEIGHTS]))
    except SafetensorError as error:
        raise RecipeError(f"the weights cannot be read: {error}", where=str(folder / WEIGHTS)) from error


def start_from(learner: Learner, origin: Origin, recipe_file: RecipeFile) -> StartedFrom:
    """Give a learner that has not begun the network, value function and normaliser of a policy; the optimiser is new.

    The layout of the observations may be another one, of the same size. Then the inputs of one name go on as they
    are, and the normaliser's mean and variance are worth one rollout's observations from here on: with the weight of
    the whole training behind them the inputs that mean something new would stay out of its range for as long again.

    Returns:
        What there is to tell of it.

    Raises:
        RecipeError: the policy's weights have other names or shapes.
    """
    _refuse_other_arrays(learner, origin, recipe_file)
    own = learner.ppo.policy.state_dict()
    learner.ppo.policy.load_state_dict({name: torch.from_numpy(np.array(origin.learnt[name])) for name in own})
    statistics, manifest = learner.statistics, origin.policy.manifest
    statistics.mean = np.array(origin.learnt["normaliser.mean"], np.float64)
    statistics.var = np.array(origin.learnt["normaliser.var"], np.float64)
    statistics.count = float(origin.learnt["normaliser.count"])
    names = [name for name, _, _ in learner.env.layout.components]
    others = tuple((old, new) for old, new in zip(manifest.observation.names, names, strict=True) if old != new)
    if others:
        statistics.count = min(statistics.count, float(learner.recipe.ppo.robots * learner.recipe.ppo.rollout_steps))
    learner.start = StartRecord(
        policy=manifest.name,
        observation=manifest.observation.layout,
        steps=manifest.training.steps,
        policy_sha256=origin.policy.sha256,
        weights_sha256=hashlib.sha256(origin.policy.files[WEIGHTS]).hexdigest(),
    )
    return StartedFrom(manifest.name, manifest.observation.layout, learner.env.layout.name, others)


def _refuse_other_kind(policy: LoadedPolicy, recipe_file: RecipeFile) -> None:
    manifest, recipe = policy.manifest, recipe_file.recipe
    pairs = (
        ("robot", manifest.robot, recipe.robot),
        ("observation size", manifest.observation.size, layout(recipe.observation).size),
        ("hidden layers", list(manifest.network.hidden_sizes), list(recipe.network.hidden)),
        ("activation", manifest.network.activation, recipe.network.activation),
    )
    if faults := [f"its {what} is {theirs}, the recipe's {own}" for what, theirs, own in pairs if theirs != own]:
        raise _refusal(manifest.name, "; ".join(faults), recipe_file)


def _refuse_chosen_by_what_is_reported(policy: LoadedPolicy, recipe_file: RecipeFile) -> None:
    """Refuse what a recipe refuses of its own selection: that one's choice of weights is in these, too."""
    chosen, seed = policy.manifest.training.selection, recipe_file.recipe.evaluation.seed
    if chosen is not None and chosen.seed == seed:
        fault = f"it was chosen in {chosen.suite!r} with seed {seed}, which is the recipe's evaluation.seed"
        mend = "Give evaluation another seed: what a policy is chosen by must not be what is reported of it."
        raise _refusal(policy.manifest.name, fault, recipe_file, mend)


def _refuse_other_arrays(learner: Learner, origin: Origin, recipe_file: RecipeFile) -> None:
    own, theirs = weights(learner), origin.learnt
    if {name: array.shape for name, array in own.items()} != {name: array.shape for name, array in theirs.items()}:
        fault = "its weights have other names or shapes than this version of waypointctl trains"
        raise _refusal(origin.policy.manifest.name, fault, recipe_file)


def _refusal(policy: str, fault: str, recipe_file: RecipeFile, mend: str = _MEND) -> RecipeError:
    problem = f"start_from: policy {policy!r} cannot be started from: {fault}"
    return RecipeError(problem, where=str(recipe_file.path), mend=mend)
