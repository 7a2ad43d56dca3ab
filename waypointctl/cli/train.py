"""`waypointctl train`: train a policy by a recipe."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.run_folder import Places
    from waypointctl.training.train import Trained


def train_policy(
    recipe: Annotated[Path, typer.Argument(metavar="RECIPE.yaml", help="What to do.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(help="The policy's folder when it is complete; replaces one.", show_default="the run's folder"),
    ] = None,
    runs: Annotated[Path, typer.Option(help="Where runs are kept: RUNS/<recipe>, or -2, -3, ...")] = Path("runs"),
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the recipe's newest run, or with the run that --out names.")
    ] = False,
    steps: Annotated[
        int | None,
        typer.Option(min=1, max=10**12, help="Shorten or stretch all phases to this many.", show_default=False),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, max=2**32 - 1, help="Use this seed, not the recipe's.", show_default=False)
    ] = None,
    threads: Annotated[int, typer.Option(min=0, max=1024, help="For physics and network; 0 is one a core.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
) -> None:
    """Train a policy with PPO and evaluate it on the paper's paths.

    Ctrl-C stops it with a checkpoint, which is a policy that can be tried, and --resume goes on from it to the very
    same weights.
    """
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.view.training import watch_training
    from waypointctl.training.installed import refuse_incomplete
    from waypointctl.training.recipe_file import load_recipe
    from waypointctl.training.run_folder import places

    with interruption() as interrupted:
        recipe_file = load_recipe(recipe)
        refuse_incomplete()
        place = places(recipe_file.recipe.name, runs, out, resume=resume)
        recipe_file = _as_asked(recipe_file, place, resume, steps, seed)

        from waypointctl.training.train import train

        with watch_training(recipe_file.recipe, f"{recipe_file.recipe.name} in {place.run}", interrupted) as view:
            trained = train(
                recipe_file,
                place.out,
                run=place.run,
                threads=threads,
                resume=resume,
                watch=view,
                evaluating=view.evaluating,
                interrupted=interrupted,
            )
    go_on = _go_on(recipe, out, runs, threads)
    _tell(trained, recipe_file, go_on, stderr=json)
    if json:
        sys.stdout.write(_json(trained, recipe_file, place))
    raise typer.Exit(0 if trained.evaluation else 130)


def _as_asked(recipe_file: RecipeFile, place: Places, resume: bool, steps: int | None, seed: int | None) -> RecipeFile:
    """Return the recipe with the steps and the seed that were asked for, or that the run began with."""
    recipe = recipe_file.recipe
    if resume:
        from waypointctl.training.checkpoint import begun_as

        recipe = begun_as(recipe_file, place.run).recipe
    if steps is not None:
        scaled = recipe_file.recipe.scaled_to(steps)
        recipe = recipe.with_phase_steps([phase.steps for phase in scaled.phases])
    if seed is not None:
        recipe = recipe.model_copy(update={"seed": seed})
    return replace(recipe_file, recipe=recipe)


def _go_on(recipe: Path, out: Path | None, runs: Path, threads: int) -> str:
    """Return the command that goes on with this run."""
    import shlex

    options = [("--out", out), ("--runs", runs if runs != Path("runs") else None), ("--threads", threads or None)]
    given = [part for name, value in options if value is not None for part in (name, str(value))]
    return shlex.join(["waypointctl", "train", str(recipe), *given, "--resume"])


def _tell(trained: Trained, recipe_file: RecipeFile, go_on: str, *, stderr: bool) -> None:
    import shlex

    from waypointctl.cli.console import console
    from waypointctl.cli.view.evaluation import evaluation_table
    from waypointctl.cli.view.training_words import span

    record = trained.policy.manifest.training
    try_it = shlex.join(["waypointctl", "eval", str(trained.folder)])
    if trained.evaluation is not None:
        people = console(stderr=stderr)
        people.print(evaluation_table(trained.evaluation, people.width))
        typer.echo(f"{trained.folder}: trained in {span(record.wall_time_s)}", err=stderr)
        return
    typer.echo(f"interrupted after {record.steps} of {recipe_file.recipe.total_steps} steps", err=stderr)
    typer.echo(f"  to go on:   {go_on}", err=stderr)
    typer.echo(f"  to try it:  {try_it}", err=stderr)


def _json(trained: Trained, recipe_file: RecipeFile, place: Places) -> str:
    import json

    record = trained.policy.manifest.training
    found = {
        "recipe": recipe_file.recipe.name,
        "recipe_sha256": record.recipe_sha256,
        "outcome": "complete" if trained.evaluation else "interrupted",
        "policy": str(trained.folder),
        "policy_sha256": trained.policy.sha256,
        "run": str(place.run),
        "seed": record.seed,
        "steps": record.steps,
        "total_steps": recipe_file.recipe.total_steps,
        "wall_time_s": record.wall_time_s,
        "evaluation": trained.evaluation.model_dump(mode="json") if trained.evaluation else None,
    }
    return f"{json.dumps(found, indent=2)}\n"
