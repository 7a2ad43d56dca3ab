"""`waypointctl train --seeds`: one recipe with several seeds, and what they came to."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final

from waypointctl.display_text import printable
from waypointctl.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from waypointctl.cli.training_asked import TrainingAsked
    from waypointctl.cli.tui.trained_seeds import SeedsTrained
    from waypointctl.training.recipe_file import RecipeFile

MOST: Final = 1000
_MEND: Final = "Give how many, as in --seeds 3, or different whole numbers from 0 to 4294967295, as in --seeds 0,1,2."


def train_with_seeds(asked: TrainingAsked, seeds_text: str) -> int:
    """Train with each seed, compare them and tell; return the exit code."""
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.tui.trained_seeds import seeds_json, tell_seeds
    from waypointctl.training.run_folder import held
    from waypointctl.training.seed_group import begin_group

    if asked.seed is not None:
        raise InputError("--seed and --seeds cannot both be given", hint="--seeds 5,6 trains with these two.")
    with interruption() as interrupted:
        own = asked.load()
        seeds = seeds_of(seeds_text, own.recipe.seed)
        group, recipe_file, threads = _place(asked, own)
        with held(group):
            if not asked.resume:
                begin_group(recipe_file, group, seeds, threads)
            trained = _train(recipe_file, seeds, group, threads, interrupted)
    tell_seeds(trained, asked.go_on, stderr=asked.json)
    if asked.json:
        sys.stdout.write(seeds_json(trained))
    return 130 if trained.compared is None else 0


def seeds_of(text: str, first: int) -> list[int]:
    """Return the seeds that were asked for: a bare number is how many, from `first` on.

    Raises:
        InputError: it is neither a number of seeds nor a list of them.
    """
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdecimal() and len(part) <= 10 for part in parts):
        raise InputError(f"--seeds: {text!r} is no number of seeds and no list of them", hint=_MEND)
    numbers = [int(part) for part in parts]
    seeds = numbers if len(numbers) > 1 else [first + number for number in range(min(numbers[0], MOST + 1))]
    if not 0 < len(seeds) <= MOST or len(set(seeds)) < len(seeds) or max(seeds) >= 2**32:
        raise InputError(f"--seeds: {text!r} is not 1 to {MOST} different seeds below 2**32", hint=_MEND)
    return seeds


def _place(asked: TrainingAsked, own: RecipeFile) -> tuple[Path, RecipeFile, int]:
    """Return the group's folder, the recipe as its runs follow it, and how many threads they are to be trained with.

    Raises:
        InputError: there is no such group, it cannot be written, or it began with other steps than asked for.
    """
    from waypointctl.training.seed_group import group_begun_as, group_place

    group = group_place(own.recipe.name, asked.runs, asked.out, resume=asked.resume)
    began, threads = group_begun_as(own, group) if asked.resume else (own, 0)
    recipe_file = asked.applied_to(own, began)
    if asked.resume and recipe_file.recipe.phases != began.recipe.phases:
        found = [[phase.steps for phase in one.recipe.phases] for one in (began, recipe_file)]
        problem = f"the group began with steps {found[0]}, not {found[1]}"
        raise InputError(problem, where=str(group), hint="Resume it as it began, or begin another group.")
    return group, recipe_file, asked.threads or threads


def _train(
    recipe_file: RecipeFile, seeds: list[int], group: Path, threads: int, interrupted: Callable[[], bool]
) -> SeedsTrained:
    import typer

    from waypointctl.cli.console import console, is_live
    from waypointctl.cli.train_one import train_watched
    from waypointctl.cli.tui.trained_seeds import SeedsTrained
    from waypointctl.training.run_folder import Places
    from waypointctl.training.seed_group import is_complete, run_of
    from waypointctl.training.seeds import compare, train_seeds

    def train_seed(one: RecipeFile, run: Path, resume: bool) -> bool:
        seed = one.recipe.seed
        title = f"{one.recipe.name}, seed {seed}, {seeds.index(seed) + 1} of {len(seeds)}, in {run}"
        if not is_live(console(stderr=True)):
            typer.echo(printable(title), err=True)
        trained = train_watched(one, Places(run, run), title, interrupted, threads=threads, resume=resume)
        return trained.evaluation is not None

    complete_before = all(is_complete(run_of(group, seed)) for seed in seeds)
    complete = train_seeds(recipe_file, seeds, group, train_seed, interrupted)
    compared = compare(recipe_file, seeds, group) if len(complete) == len(seeds) else None
    return SeedsTrained(recipe_file, seeds, group, complete, compared, complete_before)
