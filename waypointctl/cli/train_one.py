"""`waypointctl train` with one seed."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from waypointctl.cli.training_asked import TrainingAsked
    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.run_folder import Places
    from waypointctl.training.train import Trained


def train_one(asked: TrainingAsked) -> int:
    """Train, evaluate and tell; return the exit code."""
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.tui.trained import tell_trained, trained_json

    with interruption() as interrupted:
        recipe_file, place = _begin(asked)
        title = f"{recipe_file.recipe.name} in {place.run}"
        resume = asked.resume or asked.extend is not None
        trained = train_watched(recipe_file, place, title, interrupted, threads=asked.threads, resume=resume)
        drawn = _draw_curves(recipe_file, place.run)
    tell_trained(trained, recipe_file, place.run if drawn else None, asked.go_on, stderr=asked.json)
    if asked.json:
        sys.stdout.write(trained_json(trained, recipe_file, place.run, drawn=drawn))
    return 0 if trained.evaluation else 130


def _draw_curves(recipe_file: RecipeFile, run: Path) -> bool:
    """Write a run's learning curves into its folder, if it has come to a rollout; return whether it has."""
    from waypointctl.training.curves import write_curves
    from waypointctl.training.progress_file import read_progress

    rows = read_progress(run)
    if rows:
        write_curves(run, recipe_file.recipe.name, {recipe_file.recipe.seed: rows})
    return bool(rows)


def train_watched(
    recipe_file: RecipeFile,
    place: Places,
    title: str,
    interrupted: Callable[[], bool],
    *,
    threads: int,
    resume: bool,
) -> Trained:
    """Train in a run's folder while people watch, under a title."""
    from waypointctl.cli.tui.training import watch_training
    from waypointctl.training.train import train

    with watch_training(recipe_file.recipe, title, interrupted) as view:
        return train(
            recipe_file,
            place.out,
            run=place.run,
            threads=threads,
            resume=resume,
            watch=view,
            evaluating=view.evaluating,
            interrupted=interrupted,
        )


def _begin(asked: TrainingAsked) -> tuple[RecipeFile, Places]:
    """Return what is to be trained and where; a run that is extended has been taken over."""
    from waypointctl.training.run_folder import places

    recipe_file = asked.load()
    if asked.extend is not None:
        from waypointctl.training.extension import shared_checkpoints

        shared_checkpoints(asked.applied_to(recipe_file), asked.extend)  # refuses before a run is made
    place = places(recipe_file.recipe.name, asked.runs, asked.out, resume=asked.resume)
    began = None
    if asked.resume:
        from waypointctl.training.checkpoint import begun_as

        began = begun_as(recipe_file, place.run)
    recipe_file = asked.applied_to(recipe_file, began)
    if asked.extend is not None:
        from waypointctl.training.extension import extend

        extend(recipe_file, asked.extend, place.run, asked.threads)
    return recipe_file, place
