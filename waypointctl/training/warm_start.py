"""Warm start: a training that begins with another policy's weights; no torch."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import RecipeError
from waypointctl.mission.policy_name import policy_folder
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import WEIGHTS, StartRecord
from waypointctl.robots.folder import read_description
from waypointctl.robots.load import load_robot
from waypointctl.task.observation import Layout, layout
from waypointctl.task.plugins import Plugin
from waypointctl.training.events import WarmStarted
from waypointctl.training.learner import Learner
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RecipeFile

_SIZES_HINT: Final = (
    "Give the recipe the network and an observation of that policy's sizes, or another policy in warm_start."
)
_SEED_HINT: Final = "Give evaluation another seed: a policy must not be selected and reported on the same trials."


@dataclass(frozen=True, slots=True)
class WarmStart:
    """The policy that a training begins with, and its weights by name, as `Learner.export` has them."""

    policy: LoadedPolicy
    weights: dict[str, NDArray[np.generic]]

    def apply(self, learner: Learner, recipe_file: RecipeFile) -> WarmStarted:
        """Load the weights into a new learner; return an event that describes them.

        The layout of the observations may be another one, of the same size. Then inputs with the same name keep
        their meaning, and the others have a new one.

        Raises:
            RecipeError: the policy's weights have other names or shapes.
        """
        manifest, own = self.policy.manifest, _layout(recipe_file.recipe, recipe_file.plugins)
        changed = _changed_inputs(manifest.observation.names, own)
        try:
            learner.warm_start(self.weights, other_inputs=bool(changed))
        except ValueError as error:
            raise _refusal(self.policy, str(error), recipe_file, _SIZES_HINT) from error
        return WarmStarted(manifest.name, manifest.observation.layout, own.name, changed)

    def record(self) -> StartRecord:
        """Return the record for the trained policy's manifest."""
        manifest = self.policy.manifest
        return StartRecord(
            policy=manifest.name,
            observation=manifest.observation.layout,
            steps=manifest.training.steps,
            policy_sha256=self.policy.sha256,
            weights_sha256=hashlib.sha256(self.policy.files[WEIGHTS]).hexdigest(),
            selection=manifest.training.selection,
        )


def load_warm_start(recipe_file: RecipeFile) -> WarmStart | None:
    """Return the policy in the recipe's `warm_start`, a folder relative to the recipe or a name; None without one.

    Raises:
        PolicyError: the policy does not exist or is damaged.
        RecipeError: it is of other sizes than the recipe, of another activation or for another robot; its weights are
            not finite numbers; or it was selected with the seed that the recipe's evaluation has.
    """
    if recipe_file.recipe.warm_start is None:
        return None
    folder = policy_folder(recipe_file.recipe.warm_start, recipe_file.path.parent)
    policy = load_policy(folder)
    for fault, hint in misfits(policy, recipe_file.recipe, recipe_file.plugins):
        raise _refusal(policy, fault, recipe_file, hint)
    return WarmStart(policy, _weights(policy.files[WEIGHTS], str(folder / WEIGHTS)))


def misfits(policy: LoadedPolicy, recipe: Recipe, plugins: tuple[Plugin, ...] = ()) -> Iterator[tuple[str, str]]:
    """Yield each thing that keeps a training by the recipe from beginning with the policy, and how to fix it.

    The size of an observation is left out where it depends on plugins that are not given.
    """
    manifest = policy.manifest
    size = manifest.observation.size if recipe.plugins and not plugins else _layout(recipe, plugins).size
    pairs = (
        ("robot is", manifest.robot, read_description(recipe.robot_path).name),
        ("observation size is", manifest.observation.size, size),
        ("hidden layers are", list(manifest.network.hidden_sizes), list(recipe.network.hidden)),
        ("activation is", manifest.network.activation, recipe.network.activation),
    )
    if others := [f"its {what} {theirs}, the recipe's {own}" for what, theirs, own in pairs if theirs != own]:
        yield ", and ".join(others), _SIZES_HINT
    selected, seed = manifest.training.selection, recipe.evaluation.seed
    if selected is not None and selected.seed == seed:
        yield (
            f"it was selected in {selected.suite!r} with seed {seed}, which is also this recipe's evaluation.seed",
            _SEED_HINT,
        )


def not_startable(policy: LoadedPolicy, fault: str) -> str:
    """Return what is wrong with starting from a policy, as a message has it."""
    return f"cannot start from policy {policy.manifest.name!r}: {fault}"


def _refusal(policy: LoadedPolicy, fault: str, recipe_file: RecipeFile, hint: str) -> RecipeError:
    problem = f"warm_start: {not_startable(policy, fault)}"
    return RecipeError(problem, where=recipe_file.place("warm_start"), hint=hint)


def _weights(content: bytes, where: str) -> dict[str, NDArray[np.generic]]:
    from safetensors import SafetensorError  # only in the train extra
    from safetensors.numpy import load

    try:
        arrays: dict[str, NDArray[np.generic]] = load(content)
    except (SafetensorError, KeyError) as error:  # the latter: a type of numbers that numpy does not have, such as fp8
        raise RecipeError(f"the weights cannot be read: {error}", where=where) from error
    for name, array in arrays.items():
        if array.dtype.kind != "f" or not np.isfinite(array).all():
            raise RecipeError(f"the weights cannot be used: {name} is not an array of finite numbers", where=where)
    return arrays


def _layout(recipe: Recipe, plugins: tuple[Plugin, ...]) -> Layout:
    return layout(recipe.observation, load_robot(recipe.robot_path), plugins)


def _changed_inputs(names: tuple[str, ...], own: Layout) -> tuple[tuple[str, str], ...]:
    pairs = zip(names, (name for name, _, _ in own.components), strict=True)
    return tuple((old, new) for old, new in pairs if old != new)
