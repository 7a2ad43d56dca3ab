"""`waypointctl train` with one seed or several: what is trained, where, and what is printed of it."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from waypointctl.display_text import printable, shell_word
from waypointctl.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from waypointctl.cli.tui.training_result import SeedsTrained
    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.run_folder import Places
    from waypointctl.training.train import TrainingResult


RUNS: Final = Path("runs")


@dataclass(frozen=True, slots=True)
class TrainOptions:
    """The command's arguments, which its --help describes; what is None was not given."""

    recipe: Path
    out: Path | None = None
    runs: Path = RUNS
    resume: bool = False
    extend: Path | None = None
    steps: int | None = None
    seed: int | None = None
    seeds: str | None = None
    stop_at: float | None = None
    threads: int = 0
    json: bool = False
    allow_plugins: bool = False

    def load(self) -> RecipeFile:
        """Return the recipe as its file has it; whatever is missing is reported before anything is written."""
        from waypointctl.training.recipe_file import load_recipe, require_packages, with_plugins
        from waypointctl.training.recipe_references import load_recipe_to_train

        # A run that is resumed has what its recipe refers to.
        recipe_file = load_recipe(self.recipe) if self.resume else load_recipe_to_train(self.recipe)
        require_packages()
        recipe_file = with_plugins(recipe_file, allowed=self.allow_plugins)
        if not self.resume:
            self.applied_to(recipe_file)
        return recipe_file

    def applied_to(self, recipe_file: RecipeFile, began: RecipeFile | None = None) -> RecipeFile:
        """Return a recipe with the steps, seed and target of the options.

        Args:
            recipe_file: as its file has it; phases are shortened or stretched from there.
            began: as the resumed run began; None: nothing has begun.
        """
        from waypointctl.errors import RecipeError

        recipe = (began or recipe_file).recipe
        if self.steps is not None:
            scaled = recipe_file.recipe.scaled_to(self.steps)
            recipe = recipe.with_phase_steps([phase.steps for phase in scaled.phases])
        if self.seed is not None:
            recipe = recipe.model_copy(update={"seed": self.seed})
        if self.stop_at is not None:
            try:
                recipe = recipe.stopping_at(self.stop_at)
            except ValueError as error:
                hint = "Give the recipe a selection with a seed of its own."
                where = recipe_file.place("evaluation", "seed")
                raise RecipeError(f"--stop-at: {error}", where=where, hint=hint) from error
        return replace(recipe_file, recipe=recipe)

    @property
    def resume_command(self) -> str:
        """The command that continues the training."""
        options = [
            ("--seeds", self.seeds),
            ("--out", self.out),
            ("--runs", self.runs if self.runs != RUNS else None),
            ("--threads", self.threads or None),
        ]
        given = [part for name, value in options if value is not None for part in (name, str(value))]
        flags = ["--allow-plugins"] if self.allow_plugins else []
        return " ".join(map(shell_word, ["waypointctl", "train", str(self.recipe), *given, *flags, "--resume"]))


def train_one(options: TrainOptions) -> int:
    """Train, evaluate and print the result; return the exit code."""
    from waypointctl.cli.program import interruption
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
    recipe_file: RecipeFile, place: Places, title: str, interrupted: Callable[[], bool], *, threads: int, resume: bool
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


MOST: Final = 1000
_HINT: Final = "Give how many, as in --seeds 3, or different whole numbers from 0 to 4294967295, as in --seeds 0,1,2."


def train_with_seeds(options: TrainOptions, seeds_text: str) -> int:
    """Train with each seed, compare them and print the result; return the exit code."""
    from waypointctl.cli.program import interruption
    from waypointctl.cli.tui.training_result import print_seeds, seeds_json
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
    from waypointctl.cli.tui.training_result import SeedsTrained
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
