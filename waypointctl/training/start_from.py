"""Beginning a training with another policy's weights."""

from __future__ import annotations

import hashlib

import numpy as np
import torch

from waypointctl.policy.manifest import WEIGHTS, StartRecord
from waypointctl.training.export import weights
from waypointctl.training.learner import Learner
from waypointctl.training.origin import OTHER_SIZES_MEND, Origin, refusal
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.status import StartedFrom


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
        selection=manifest.training.selection,
    )
    return StartedFrom(manifest.name, manifest.observation.layout, learner.env.layout.name, others)


def _refuse_other_arrays(learner: Learner, origin: Origin, recipe_file: RecipeFile) -> None:
    own, theirs = weights(learner), origin.learnt
    if {name: array.shape for name, array in own.items()} != {name: array.shape for name, array in theirs.items()}:
        fault = "its weights have other names or shapes than this version of waypointctl trains"
        raise refusal(origin.policy, fault, recipe_file, OTHER_SIZES_MEND)
