"""The result of a training, as text and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.train import TrainingResult


def print_result(
    result: TrainingResult, recipe_file: RecipeFile, curves_in: Path | None, resume_command: str, *, stderr: bool
) -> None:
    """Print how the policy did, or, of a training that was interrupted, the commands to continue.

    Args:
        result: of the training.
        recipe_file: that it followed.
        curves_in: the folder of the learning curves; None where there are none.
        resume_command: continues an interrupted training.
        stderr: print there.
    """
    import typer

    from waypointctl.cli.console import console
    from waypointctl.cli.tui.grid_view import GridView
    from waypointctl.cli.tui.training_text import duration, outcome_text
    from waypointctl.display_text import printable, shell_word
    from waypointctl.evaluation.result import EVALUATION
    from waypointctl.evaluation.tables import results_grid
    from waypointctl.training.curves import CURVES, PICTURE

    last_step, folder = recipe_file.recipe.last_step, printable(result.folder)
    if result.evaluation is None:
        lines = [
            f"interrupted after {result.steps} of {last_step} steps",
            f"  to resume:  {resume_command}",
            f"  to try it:  waypointctl eval {shell_word(result.folder)}",
        ]
        closing = []
    else:
        table = GridView(results_grid([result.evaluation]), (str(result.folder / EVALUATION),))
        console(stderr=stderr).print(table)
        lines = [] if result.selection is None else [outcome_text(result.selection, last_step)]
        before = "the training was complete before; nothing was left to train"
        closing = [f"{folder}: {before if result.already_complete else f'trained in {duration(result.wall_time_s)}'}"]
    if curves_in:
        lines.append(f"{printable(curves_in / PICTURE)}: the learning curves; as numbers in {CURVES}")
    for line in (*lines, *closing):
        typer.echo(line, err=stderr)


def result_json(result: TrainingResult, recipe_file: RecipeFile, run: Path, *, drawn: bool) -> str:
    """Return the JSON object of `waypointctl train --json`; `drawn`: whether there are learning curves."""
    import json

    from waypointctl.training.curves import CURVES, PICTURE

    record = result.policy.manifest.training
    found = {
        "recipe": recipe_file.recipe.name,
        "recipe_sha256": record.recipe_sha256,
        "outcome": "complete" if result.evaluation else "interrupted",
        "policy": str(result.folder),
        "policy_sha256": result.policy.sha256,
        "run": str(run),
        "seed": record.seed,
        "steps": record.steps,
        "total_steps": recipe_file.recipe.last_step,
        "wall_time_s": record.wall_time_s,
        "evaluation": result.evaluation.model_dump(mode="json") if result.evaluation else None,
        "already_complete": result.already_complete,
        "threads": {"physics": result.threads.physics, "torch": result.threads.torch},
        "curves": str(run / CURVES) if drawn else None,
        "picture": str(run / PICTURE) if drawn else None,
        "trained_steps": result.steps,
        "trained_wall_time_s": round(result.wall_time_s, 1),
        **_selection(result),
    }
    return f"{json.dumps(found, indent=2)}\n"


def _selection(result: TrainingResult) -> dict[str, Any]:
    selection = result.selection
    if selection is None or not selection.candidates:
        return {"selection": None, "target": None}
    best, plan = selection.best, selection.recipe
    found = {
        "suite": plan.suite,
        "seed": plan.seed,
        "selected": best.model_dump(mode="json") | {"success_rate": best.success_rate},
        "candidates": [
            one.model_dump(mode="json") | {"success_rate": one.success_rate} for one in selection.candidates
        ],
    }
    if plan.stop_at is None:
        return {"selection": found, "target": None}
    target = {
        "stop_at": plan.stop_at,
        "met": selection.met,
        "steps": best.steps if selection.met else None,
        "wall_time_s": best.wall_time_s if selection.met else None,
    }
    return {"selection": found, "target": target}
