"""Telling when a training has diverged: from numbers that are not finite no update comes back."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from waypointctl.errors import RecipeError
from waypointctl.training.export import weights
from waypointctl.training.learner import Learner
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import newest_checkpoint


def refuse_diverged(learner: Learner, recipe_file: RecipeFile, run: Path) -> None:
    """End a training whose network or normaliser has numbers that are not finite.

    Raises:
        RecipeError: it has, with the step and the last checkpoint, which was taken before.
    """
    if all(np.isfinite(array).all() for array in weights(learner).values()):
        return
    last = newest_checkpoint(run)
    kept = f"the last checkpoint is {last}" if last else "there is no checkpoint yet"
    problem = f"the training diverged: at step {learner.steps} the network has numbers that are not finite; {kept}"
    hint = "Begin another run with a lower learning_rate, reward_scale or max_gradient."
    raise RecipeError(problem, where=str(recipe_file.path), hint=hint)
