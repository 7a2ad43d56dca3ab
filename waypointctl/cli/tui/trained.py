"""What a training came to, for people and for machines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.train import Trained


def tell_trained(
    trained: Trained, recipe_file: RecipeFile, curves_in: Path | None, go_on: str, *, stderr: bool
) -> None:
    """Print how the policy did, or, of a training that was interrupted, the commands to go on with.

    Args:
        trained: what it came to.
        recipe_file: that it was trained by.
        curves_in: the folder of the learning curves; None where there are none.
        go_on: the command that goes on with an interrupted training.
        stderr: print there.
    """
    import typer

    from waypointctl.cli.console import console
    from waypointctl.cli.tui.evaluation import evaluation_table
    from waypointctl.cli.tui.training_words import outcome, span
    from waypointctl.display_text import printable, shell_word
    from waypointctl.evaluation.result import EVALUATION
    from waypointctl.training.curves import CURVES, PICTURE

    curves = f"{printable(curves_in / PICTURE)}: the learning curves; as numbers in {CURVES}" if curves_in else None
    if trained.evaluation is not None:
        people = console(stderr=stderr)
        people.print(evaluation_table(trained.evaluation, trained.folder / EVALUATION))
        if trained.selection is not None:
            typer.echo(outcome(trained.selection, recipe_file.recipe.total_steps), err=stderr)
        if curves:
            typer.echo(curves, err=stderr)
        if trained.complete_before:
            typer.echo(
                f"{printable(trained.folder)}: the training was complete before; nothing was left to train", err=stderr
            )
        else:
            typer.echo(f"{printable(trained.folder)}: trained in {span(trained.wall_time_s)}", err=stderr)
        return
    try_it = f"waypointctl eval {shell_word(trained.folder)}"
    typer.echo(f"interrupted after {trained.steps} of {recipe_file.recipe.total_steps} steps", err=stderr)
    typer.echo(f"  to go on:   {go_on}", err=stderr)
    typer.echo(f"  to try it:  {try_it}", err=stderr)
    if curves:
        typer.echo(curves, err=stderr)


def trained_json(trained: Trained, recipe_file: RecipeFile, run: Path, *, drawn: bool) -> str:
    """Return the JSON object of `waypointctl train --json`; `drawn` says whether there are learning curves."""
    import json

    from waypointctl.training.curves import CURVES, PICTURE

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
        "complete_before": trained.complete_before,
        "threads": {"physics": trained.threads.physics, "torch": trained.threads.torch},
        "curves": str(run / CURVES) if drawn else None,
        "picture": str(run / PICTURE) if drawn else None,
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
