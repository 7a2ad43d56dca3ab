"""`waypointctl train --seeds`: one recipe with several seeds, compared."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final

from waypointctl.display_text import printable
from waypointctl.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from waypointctl.cli.train_options import TrainOptions
    from waypointctl.cli.tui.training_seeds import SeedsTrained
    from waypointctl.training.recipe_file import RecipeFile

MOST: Final = 1000
_HINT: Final = "Give how many, as in --seeds 3, or different whole numbers from 0 to 4294967295, as in --seeds 0,1,2."


def train_with_seeds(options: TrainOptions, seeds_text: str) -> int:
    """Train with each seed, compare them and print the result; return the exit code."""
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.tui.training_seeds import print_seeds, seeds_json
    from waypointctl.training.run_folder import held
    from waypointctl.training.seeds import begin_group

    if options.seed is not None:
        raise InputError("--seed and --seeds cannot both be given", hint="--seeds 5,6 trains with these two.")
    with interruption() as interrupted:
        own = options.load()
        seeds = seeds_of(seeds_text, own.recipe.seed)
        group, recipe_file, threads = _place(options, own)
        with held(group):
            if not options.resume:
                begin_group(recipe_file, group, seeds, threads)
            trained = _train(recipe_file, seeds, group, threads, interrupted)
    print_seeds(trained, options.resume_command, stderr=options.json)
    if options.json:
        sys.stdout.write(seeds_json(trained))
    return 130 if trained.compared is None else 0


def seeds_of(text: str, first: int) -> list[int]:
    """Return the requested seeds: a bare number is how many, from `first` on.

    Raises:
        InputError: it is neither a number of seeds nor a list of them.
    """
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdecimal() and len(part) <= 10 for part in parts):
        raise InputError(f"--seeds: expected a count or a comma-separated list of seeds, not {text!r}", hint=_HINT)
    numbers = [int(part) for part in parts]
    seeds = numbers if len(numbers) > 1 else [first + number for number in range(min(numbers[0], MOST + 1))]
    if not 0 < len(seeds) <= MOST or len(set(seeds)) < len(seeds) or max(seeds) >= 2**32:
        raise InputError(f"--seeds: expected 1 to {MOST} different seeds below 2**32, not {text!r}", hint=_HINT)
    return seeds


def _place(options: TrainOptions, own: RecipeFile) -> tuple[Path, RecipeFile, int]:
    """Return the group's folder, the recipe as its runs follow it, and how many threads they are to be trained with.

    Raises:
        InputError: there is no such group, it cannot be written, or it began with other steps.
    """
    from waypointctl.training.run_folder import group_place
    from waypointctl.training.seeds import group_begun_as

    group = group_place(own.recipe.name, options.runs, options.out, resume=options.resume)
    began, threads = group_begun_as(own, group) if options.resume else (own, 0)
    recipe_file = options.applied_to(own, began)
    if options.resume and recipe_file.recipe.phases != began.recipe.phases:
        found = [[phase.steps for phase in one.recipe.phases] for one in (began, recipe_file)]
        problem = f"the group began with steps {found[0]}, not {found[1]}"
        raise InputError(problem, where=str(group), hint="Resume it as it began, or begin another group.")
    return group, recipe_file, options.threads or threads


def _train(
    recipe_file: RecipeFile, seeds: list[int], group: Path, threads: int, interrupted: Callable[[], bool]
) -> SeedsTrained:
    import typer

    from waypointctl.cli.console import console, is_live
    from waypointctl.cli.train_one import train_with_view
    from waypointctl.cli.tui.training_seeds import SeedsTrained
    from waypointctl.training.run_folder import Places
    from waypointctl.training.seeds import compare, is_complete, run_of, train_seeds

    def train_seed(one: RecipeFile, run: Path, resume: bool) -> bool:
        seed = one.recipe.seed
        title = f"{one.recipe.name}, seed {seed}, {seeds.index(seed) + 1} of {len(seeds)}, in {run}"
        if not is_live(console(stderr=True)):
            typer.echo(printable(title), err=True)
        result = train_with_view(one, Places(run, run), title, interrupted, threads=threads, resume=resume)
        return result.evaluation is not None

    already_complete = all(is_complete(run_of(group, seed)) for seed in seeds)
    complete = train_seeds(recipe_file, seeds, group, train_seed, interrupted)
    compared = compare(recipe_file, seeds, group) if len(complete) == len(seeds) else None
    return SeedsTrained(recipe_file, seeds, group, complete, compared, already_complete)
