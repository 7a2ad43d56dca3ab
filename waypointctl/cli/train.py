"""`waypointctl train`: train a policy by a recipe."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from waypointctl.training.recipe_file import RecipeFile
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
    extend: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN",
            help="Go on from this run, whose recipe is the beginning of this one, to what this one makes from nothing.",
            show_default=False,
        ),
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option(min=1, max=10**12, help="Shorten or stretch all phases to this many.", show_default=False),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, max=2**32 - 1, help="Use this seed, not the recipe's.", show_default=False)
    ] = None,
    seeds: Annotated[
        str | None,
        typer.Option(
            metavar="N|A,B,...",
            help="Train with N seeds from the recipe's on, or with these, and compare: RUNS/<recipe>-seeds.",
            show_default=False,
        ),
    ] = None,
    stop_at: Annotated[
        float | None,
        typer.Option(
            min=0.01, max=1.0, help="End when a checkpoint has this success rate in its test.", show_default=False
        ),
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
    from waypointctl.training.run_folder import places

    if extend is not None:
        _refuse_with_extend({"--resume": resume, "--steps": steps, "--seeds": seeds, "--stop-at": stop_at})
    if seeds is not None:
        from waypointctl.cli.train_seeds import train_with_seeds

        raise typer.Exit(train_with_seeds(recipe, seeds, seed, out, runs, resume, steps, stop_at, threads, json))

    with interruption() as interrupted:
        recipe_file = load_to_train(recipe, stop_at, resume=resume)
        if extend is not None:
            from waypointctl.training.extension import extend as take_over
            from waypointctl.training.extension import shared_checkpoints

            shared_checkpoints(as_asked(recipe_file, recipe_file, None, seed, None), extend)  # before a run is made
        place = places(recipe_file.recipe.name, runs, out, resume=resume)
        if resume:
            from waypointctl.training.checkpoint import begun_as

            recipe_file = as_asked(begun_as(recipe_file, place.run), recipe_file, steps, seed, stop_at)
        else:
            recipe_file = as_asked(recipe_file, recipe_file, steps, seed, stop_at)
        if extend is not None:
            take_over(recipe_file, extend, place.run, threads)

        from waypointctl.training.train import train

        with watch_training(recipe_file.recipe, f"{recipe_file.recipe.name} in {place.run}", interrupted) as view:
            trained = train(
                recipe_file,
                place.out,
                run=place.run,
                threads=threads,
                resume=resume or extend is not None,
                watch=view,
                evaluating=view.evaluating,
                interrupted=interrupted,
            )
    _tell(trained, recipe_file, go_on(recipe, out, runs, threads), stderr=json)
    if json:
        sys.stdout.write(_json(trained, recipe_file, place.run))
    raise typer.Exit(0 if trained.evaluation else 130)


def _refuse_with_extend(options: dict[str, object]) -> None:
    for name, value in options.items():
        if value:
            raise typer.BadParameter(f"cannot be combined with --extend: {name} is for other runs", param_hint=name)


def load_to_train(recipe: Path, stop_at: float | None, *, resume: bool) -> RecipeFile:
    """Return a recipe that there is all for; what it refuses, it refuses before anything is written.

    Raises:
        InputError: packages are missing, or the recipe or what it refers to is wrong or not there.
    """
    from waypointctl.training.installed import refuse_incomplete
    from waypointctl.training.recipe_file import load_recipe

    recipe_file = load_recipe(recipe)
    refuse_incomplete()
    if not resume:  # a run has what it needs
        from waypointctl.training.start_from import load_origin
        from waypointctl.training.testing import refuse_unknown_suite

        load_origin(recipe_file)
        refuse_unknown_suite(as_asked(recipe_file, recipe_file, None, None, stop_at))
    return recipe_file


def as_asked(
    began: RecipeFile, recipe_file: RecipeFile, steps: int | None, seed: int | None, stop_at: float | None
) -> RecipeFile:
    """Return the recipe as the training began, with the steps, seed and target that were asked for.

    Raises:
        RecipeError: a target was asked for that the recipe cannot be given.
    """
    from waypointctl.errors import RecipeError

    recipe = began.recipe
    if steps is not None:
        scaled = recipe_file.recipe.scaled_to(steps)
        recipe = recipe.with_phase_steps([phase.steps for phase in scaled.phases])
    if seed is not None:
        recipe = recipe.model_copy(update={"seed": seed})
    if stop_at is not None:
        try:
            recipe = recipe.stopping_at(stop_at)
        except ValueError as error:
            mend = "Give the recipe a selection with a seed of its own."
            raise RecipeError(f"--stop-at: {error}", where=str(recipe_file.path), mend=mend) from error
    return replace(recipe_file, recipe=recipe)


def go_on(recipe: Path, out: Path | None, runs: Path, threads: int, seeds: str | None = None) -> str:
    """Return the command that goes on with this run."""
    import shlex

    options = [
        ("--seeds", seeds),
        ("--out", out),
        ("--runs", runs if runs != Path("runs") else None),
        ("--threads", threads or None),
    ]
    given = [part for name, value in options if value is not None for part in (name, str(value))]
    return shlex.join(["waypointctl", "train", str(recipe), *given, "--resume"])


def _tell(trained: Trained, recipe_file: RecipeFile, go_on: str, *, stderr: bool) -> None:
    import shlex

    from waypointctl.cli.console import console
    from waypointctl.cli.view.evaluation import evaluation_table
    from waypointctl.cli.view.training_words import outcome, span

    if trained.evaluation is not None:
        people = console(stderr=stderr)
        people.print(evaluation_table(trained.evaluation, people.width))
        if trained.selection is not None:
            typer.echo(outcome(trained.selection, recipe_file.recipe.total_steps), err=stderr)
        typer.echo(f"{trained.folder}: trained in {span(trained.wall_time_s)}", err=stderr)
        return
    try_it = shlex.join(["waypointctl", "eval", str(trained.folder)])
    typer.echo(f"interrupted after {trained.steps} of {recipe_file.recipe.total_steps} steps", err=stderr)
    typer.echo(f"  to go on:   {go_on}", err=stderr)
    typer.echo(f"  to try it:  {try_it}", err=stderr)


def _json(trained: Trained, recipe_file: RecipeFile, run: Path) -> str:
    import json

    record = trained.policy.manifest.training
    found = {
        "recipe": recipe_file.recipe.name,
        "recipe_sha256": record.recipe_sha256,
        "outcome": "complete" if trained.evaluation else "interrupted",
        "policy": str(trained.folder),
        "policy_sha256": trained.policy.sha256,
        "run": str(run),
        "seed": record.seed,
        "steps": record.steps,
        "total_steps": recipe_file.recipe.total_steps,
        "wall_time_s": record.wall_time_s,
        "evaluation": trained.evaluation.model_dump(mode="json") if trained.evaluation else None,
        "trained_steps": trained.steps,
        "trained_wall_time_s": round(trained.wall_time_s, 1),
        **_selected(trained),
    }
    return f"{json.dumps(found, indent=2)}\n"


def _selected(trained: Trained) -> dict[str, Any]:
    selection = trained.selection
    if selection is None or not selection.candidates:
        return {"selection": None, "target": None}
    best, plan = selection.best, selection.recipe
    chosen = {
        "suite": plan.suite,
        "seed": plan.seed,
        "chosen": best.model_dump(mode="json") | {"success_rate": best.success_rate},
        "candidates": [
            one.model_dump(mode="json") | {"success_rate": one.success_rate} for one in selection.candidates
        ],
    }
    if plan.stop_at is None:
        return {"selection": chosen, "target": None}
    at = best if selection.met else None
    target = {
        "stop_at": plan.stop_at,
        "met": selection.met,
        "steps": at.steps if at else None,
        "wall_time_s": at.wall_time_s if at else None,
    }
    return {"selection": chosen, "target": target}
