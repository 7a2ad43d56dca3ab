"""What a policy was trained on, as the recipe beside it says."""

from __future__ import annotations

import hashlib
from pathlib import Path

from waypointctl.errors import RecipeError
from waypointctl.evaluation.suite import Training
from waypointctl.mission.yaml_source import read_source
from waypointctl.policy.manifest import Manifest
from waypointctl.training.recipe_file import load_recipe
from waypointctl.training.run_folder import RECIPE


def trained_on(folder: Path, manifest: Manifest) -> Training | None:
    """Return whether a policy was trained on a single point or on waypoints.

    Args:
        folder: the bundle.
        manifest: the bundle's, with the hash of the recipe that made it.

    Returns:
        None where that recipe is not in the folder, was changed, or is not read any more.
    """
    try:
        source = read_source(folder / RECIPE, RecipeError)
        if hashlib.sha256(source).hexdigest() != manifest.training.recipe_sha256:
            return None
        cases = load_recipe(folder / RECIPE).recipe.course.cases
    except RecipeError:
        return None
    points = {point.position_m for case in cases or () for point in case.waypoints}
    return "single point" if cases and len(points) == 1 else "waypoints"
