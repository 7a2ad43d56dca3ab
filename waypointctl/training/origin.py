"""The policy that a training begins with, and whether a recipe can begin with it; no torch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import RecipeError
from waypointctl.mission.policy_name import policy_folder
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import WEIGHTS
from waypointctl.task.observation import layout
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RecipeFile

OTHER_SIZES_MEND: Final = (
    "Give the recipe the network and an observation of that policy's sizes, or another policy in start_from."
)
_SEED_MEND: Final = "Give evaluation another seed: what a policy is chosen by must not be what is reported of it."


@dataclass(frozen=True, slots=True)
class Origin:
    """The policy that a training begins with: all that it learnt, by name as `export.weights` has it."""

    policy: LoadedPolicy
    learnt: dict[str, NDArray[np.generic]]


def load_origin(recipe_file: RecipeFile) -> Origin | None:
    """Return the policy in the recipe's `start_from`, a folder beside the recipe or a name; None without one.

    Raises:
        PolicyError: there is no such policy, or it is damaged.
        RecipeError: it is of other sizes than the recipe, of another activation or for another robot; its weights are
            not finite numbers; or it was chosen with the seed that the recipe's evaluation has.
    """
    if recipe_file.recipe.start_from is None:
        return None
    folder = policy_folder(recipe_file.recipe.start_from, recipe_file.path.parent)
    policy = load_policy(folder)
    for fault, hint in misfits(policy, recipe_file.recipe):
        raise refusal(policy, fault, recipe_file, hint)
    return Origin(policy, _learnt(policy.files[WEIGHTS], str(folder / WEIGHTS)))


def _learnt(weights: bytes, where: str) -> dict[str, NDArray[np.generic]]:
    from safetensors import SafetensorError  # comes with the train extra alone
    from safetensors.numpy import load

    try:
        arrays: dict[str, NDArray[np.generic]] = load(weights)
    except (SafetensorError, KeyError) as error:  # the latter: a type of numbers that numpy does not have, such as fp8
        raise RecipeError(f"the weights cannot be read: {error}", where=where) from error
    for name, array in arrays.items():
        if array.dtype.kind != "f" or not np.isfinite(array).all():
            raise RecipeError(f"the weights cannot be used: {name} is not an array of finite numbers", where=where)
    return arrays


def misfits(policy: LoadedPolicy, recipe: Recipe) -> Iterator[tuple[str, str]]:
    """Yield each thing that keeps a training by the recipe from beginning with the policy, and how to fix it."""
    manifest = policy.manifest
    pairs = (
        ("robot is", manifest.robot, recipe.robot),
        ("observation size is", manifest.observation.size, layout(recipe.observation).size),
        ("hidden layers are", list(manifest.network.hidden_sizes), list(recipe.network.hidden)),
        ("activation is", manifest.network.activation, recipe.network.activation),
    )
    if others := [f"its {what} {theirs}, the recipe's {own}" for what, theirs, own in pairs if theirs != own]:
        yield ", and ".join(others), OTHER_SIZES_MEND
    # What a recipe refuses of its own selection: that one's choice of weights is in these, too.
    chosen, seed = manifest.training.selection, recipe.evaluation.seed
    if chosen is not None and chosen.seed == seed:
        yield f"it was chosen in {chosen.suite!r} with seed {seed}, which is the recipe's evaluation.seed", _SEED_MEND


def not_startable(policy: LoadedPolicy, fault: str) -> str:
    """Return what is wrong with starting from a policy, as a message has it."""
    return f"policy {policy.manifest.name!r} cannot be started from: {fault}"


def refusal(policy: LoadedPolicy, fault: str, recipe_file: RecipeFile, hint: str) -> RecipeError:
    """Return the error for a policy that a recipe names and cannot begin with."""
    problem = f"start_from: {not_startable(policy, fault)}"
    return RecipeError(problem, where=recipe_file.place("start_from"), hint=hint)
