"""`waypointctl train --seeds`: one recipe with several seeds, and what they came to."""

from __future__ import annotations

import json as json_text
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

import typer

from waypointctl.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.seeds import SeedsResult

MOST: Final = 1000
_MEND: Final = "Give how many, as in --seeds 3, or different whole numbers from 0 to 4294967295, as in --seeds 0,1,2."


def train_with_seeds(
    recipe: Path,
    seeds_text: str,
    seed: int | None,
    out: Path | None,
    runs: Path,
    resume: bool,
    steps: int | None,
    stop_at: float | None,
    threads: int,
    json: bool,
) -> int:
    """Train with each seed, compare them and tell; return the exit code. The arguments are the command's."""
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.train import as_asked, go_on, load_to_train
    from waypointctl.training.run_folder import held
    from waypointctl.training.seed_group import begin_group, group_begun_as, group_place

    if seed is not None:
        raise InputError("--seed and --seeds cannot both be given", mend="--seeds 5,6 trains with these two.")
    with interruption() as interrupted:
        recipe_file = load_to_train(recipe, stop_at, resume=resume)
        seeds = seeds_of(seeds_text, recipe_file.recipe.seed)
        group = group_place(recipe_file.recipe.name, runs, out, resume=resume)
        began = group_begun_as(recipe_file, group) if resume else recipe_file
        asked = as_asked(began, recipe_file, steps, None, stop_at)
        if resume and asked.recipe.phases != began.recipe.phases:
            found = [[phase.steps for phase in one.recipe.phases] for one in (began, asked)]
            problem = f"the group began with steps {found[0]}, not {found[1]}"
            raise InputError(problem, where=str(group), mend="Resume it as it began, or begin another group.")
        with held(group):
            if not resume:
                begin_group(asked, group, seeds)
            complete, compared = _train(asked, seeds, group, threads, interrupted)
    command = go_on(recipe, out, runs, threads, seeds_text)
    _tell(asked, seeds, group, complete, compared, command, stderr=json)
    if json:
        sys.stdout.write(_json(asked, seeds, group, compared))
    return 130 if compared is None else 0


def seeds_of(text: str, first: int) -> list[int]:
    """Return the seeds that were asked for: a bare number is how many, from `first` on.

    Raises:
        InputError: it is neither a number of seeds nor a list of them.
    """
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdecimal() and len(part) <= 10 for part in parts):
        raise InputError(f"--seeds: {text!r} is no number of seeds and no list of them", mend=_MEND)
    numbers = [int(part) for part in parts]
    seeds = numbers if len(numbers) > 1 else [first + number for number in range(min(numbers[0], MOST + 1))]
    if not 0 < len(seeds) <= MOST or len(set(seeds)) < len(seeds) or max(seeds) >= 2**32:
        raise InputError(f"--seeds: {text!r} is not 1 to {MOST} different seeds below 2**32", mend=_MEND)
    return seeds


def _train(
    recipe_file: RecipeFile, seeds: list[int], group: Path, threads: int, interrupted: Callable[[], bool]
) -> tuple[list[int], SeedsResult | None]:
    """Return the seeds that came to their end, and their comparison once all have."""
    from waypointctl.cli.console import console, is_live
    from waypointctl.cli.view.training import watch_training
    from waypointctl.training.seeds import compare, train_seeds
    from waypointctl.training.train import train

    def train_one(one: RecipeFile, run: Path, resume: bool) -> bool:
        seed = one.recipe.seed
        title = f"{one.recipe.name}, seed {seed}, {seeds.index(seed) + 1} of {len(seeds)}, in {run}"
        if not is_live(console(stderr=True)):
            typer.echo(title, err=True)
        with watch_training(one.recipe, title, interrupted) as view:
            trained = train(
                one,
                run,
                run=run,
                threads=threads,
                resume=resume,
                watch=view,
                evaluating=view.evaluating,
                interrupted=interrupted,
            )
        return trained.evaluation is not None

    complete = train_seeds(recipe_file, seeds, group, train_one, interrupted)
    return complete, compare(recipe_file, seeds, group) if len(complete) == len(seeds) else None


def _tell(
    recipe_file: RecipeFile,
    seeds: list[int],
    group: Path,
    complete: list[int],
    compared: SeedsResult | None,
    command: str,
    *,
    stderr: bool,
) -> None:
    from waypointctl.cli.console import console
    from waypointctl.cli.view.seeds import seeds_table
    from waypointctl.training.seeds import CURVES, PICTURE

    if compared is None:
        typer.echo(f"interrupted with {len(complete)} of {len(seeds)} seeds trained", err=stderr)
        typer.echo(f"  to go on:   {command}", err=stderr)
        return
    console(stderr=stderr).print(seeds_table(recipe_file.recipe.name, compared))
    typer.echo(f"{group / PICTURE}: the learning curves; as numbers in {CURVES}", err=stderr)


def _json(recipe_file: RecipeFile, seeds: list[int], group: Path, compared: SeedsResult | None) -> str:
    from waypointctl.training.seeds import CURVES, PICTURE

    found = {
        "recipe": recipe_file.recipe.name,
        "recipe_sha256": recipe_file.sha256,
        "outcome": "interrupted" if compared is None else "complete",
        "folder": str(group),
        "asked": seeds,
        "curves": None if compared is None else str(group / CURVES),
        "picture": None if compared is None else str(group / PICTURE),
        **({"seeds": [], "spread": {}} if compared is None else compared.to_dict()),
    }
    return f"{json_text.dumps(found, indent=2)}\n"
