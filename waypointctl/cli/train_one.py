"""`waypointctl train` with one seed."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from waypointctl.cli.train_options import TrainOptions
    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.run_folder import Places
    from waypointctl.training.train import TrainingResult


def train_one(options: TrainOptions) -> int:
    """Train, evaluate and print the result; return the exit code."""
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.tui.training_result import print_result, result_json

    with interruption() as interrupted:
        recipe_file, place = _begin(options)
        title = f"{recipe_file.recipe.name} in {place.run}"
        resume = options.resume or options.extend is not None
        result = train_with_view(recipe_file, place, title, interrupted, threads=options.threads, resume=resume)
        drawn = _draw_curves(recipe_file, place.run)
    print_result(result, recipe_file, place.run if drawn else None, options.resume_command, stderr=options.json)
    if options.json:
        sys.stdout.write(result_json(result, recipe_file, place.run, drawn=drawn))
    return 0 if result.evaluation else 130


def _draw_curves(recipe_file: RecipeFile, run: Path) -> bool:
    """Write a run's learning curves into its folder, if it has a rollout; return whether it has."""
    from waypointctl.training.curves import write_curves
    from waypointctl.training.progress import read_progress

    rows = read_progress(run)
    if rows:
        write_curves(run, recipe_file.recipe.name, {recipe_file.recipe.seed: rows})
    return bool(rows)


def train_with_view(
    recipe_file: RecipeFile,
    place: Places,
    title: str,
    interrupted: Callable[[], bool],
    *,
    threads: int,
    resume: bool,
) -> TrainingResult:
    """Train in a run's folder and show it on stderr, under a title."""
    from waypointctl.cli.tui.training import training_view
    from waypointctl.training.train import train

    with training_view(recipe_file.recipe, title, interrupted) as view:
        return train(
            recipe_file,
            place.out,
            run=place.run,
            threads=threads,
            resume=resume,
            on_event=view,
            interrupted=interrupted,
        )


def _begin(options: TrainOptions) -> tuple[RecipeFile, Places]:
    """Return what is to be trained and where; the checkpoints of a run that is extended have been copied."""
    from waypointctl.training.run_folder import places

    recipe_file = options.load()
    if options.extend is not None:
        from waypointctl.training.checkpoint import shared_checkpoints

        shared_checkpoints(options.applied_to(recipe_file), options.extend)  # refuses before a run is made
    place = places(recipe_file.recipe.name, options.runs, options.out, resume=options.resume)
    began = None
    if options.resume:
        from waypointctl.training.checkpoint import begun_as

        began = begun_as(recipe_file, place.run)
    recipe_file = options.applied_to(recipe_file, began)
    if options.extend is not None:
        from waypointctl.training.checkpoint import extend

        extend(recipe_file, options.extend, place.run, options.threads)
    return recipe_file, place
