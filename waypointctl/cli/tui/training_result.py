"""The results of trainings, with one seed or several: as tables, as text and as JSON."""

from __future__ import annotations

from dataclasses import dataclass
from json import dumps
from typing import TYPE_CHECKING, Any, Final

import typer

from waypointctl.cli.console import console
from waypointctl.cli.tui.tables import GridView
from waypointctl.cli.tui.training_text import count, duration, exact_percent, outcome_text
from waypointctl.display_text import printable, shell_word
from waypointctl.evaluation.grid import Column, Grid
from waypointctl.evaluation.result import EVALUATION
from waypointctl.evaluation.tables import results_grid
from waypointctl.training.curves import CURVES, PICTURE

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.seeds import SeedsResult, Spread
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
    return f"{dumps(found, indent=2)}\n"


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


# By quantity: the heading, how a number is written, and what is left out first on a narrow terminal.
_COLUMNS: Final[dict[str, tuple[str, Callable[[float], str], int]]] = {
    "success_rate": ("success", exact_percent, 0),
    "fall_rate": ("falls", exact_percent, 1),
    "timeout_rate": ("time-outs", exact_percent, 2),
    "spl": ("SPL", "{:.3f}".format, 3),
    "selection_rate": ("selection", exact_percent, 6),
    "steps": ("steps", count, 4),
    "wall_time_s": ("time", duration, 5),
}


@dataclass(frozen=True, slots=True)
class SeedsTrained:
    """A training with several seeds, finished or interrupted."""

    recipe_file: RecipeFile  # that the runs follow
    seeds: list[int]  # requested
    group: Path  # the folder of the runs
    complete: list[int]  # the seeds whose runs are finished
    compared: SeedsResult | None  # their results; None as long as a run is not finished
    already_complete: bool  # all of them were trained before


def print_seeds(trained: SeedsTrained, resume_command: str, *, stderr: bool) -> None:
    """Print a row for each seed, or, of a training that was interrupted, the command to continue."""
    from waypointctl.training.seeds import RESULTS

    if trained.compared is None:
        typer.echo(f"interrupted with {len(trained.complete)} of {len(trained.seeds)} seeds trained", err=stderr)
        typer.echo(f"  to resume:  {resume_command}", err=stderr)
        return
    if trained.already_complete:
        typer.echo(
            f"{printable(trained.group)}: every seed was trained to its end before; nothing is left to train",
            err=stderr,
        )
    table = seeds_table(trained.recipe_file.recipe.name, trained.compared, trained.group / RESULTS)
    console(stderr=stderr).print(table)
    typer.echo(f"{printable(trained.group / PICTURE)}: the learning curves; as numbers in {CURVES}", err=stderr)


def seeds_json(trained: SeedsTrained) -> str:
    """Return the JSON object of `waypointctl train --seeds --json`."""
    group, compared = trained.group, trained.compared
    found = {
        "recipe": trained.recipe_file.recipe.name,
        "recipe_sha256": trained.recipe_file.sha256,
        "outcome": "interrupted" if compared is None else "complete",
        "folder": str(group),
        "requested_seeds": trained.seeds,
        "already_complete": trained.already_complete,
        "curves": None if compared is None else str(group / CURVES),
        "picture": None if compared is None else str(group / PICTURE),
        **({"seeds": [], "spread": {}} if compared is None else compared.to_dict()),
    }
    return f"{dumps(found, indent=2)}\n"


def seeds_table(name: str, compared: SeedsResult, kept: Path) -> GridView:
    """Return a row for each seed, and mean, standard deviation, lowest and highest over them.

    Args:
        name: of the recipe.
        compared: the seeds.
        kept: the file that has all columns.
    """
    return GridView(_grid(name, compared), (str(kept),), ruled=(len(compared.results) - 1,))


def _grid(name: str, compared: SeedsResult) -> Grid:

    columns = {quantity: column for quantity, column in _COLUMNS.items() if quantity in compared.spread}
    rows = [
        (str(result.seed), *(text(getattr(result, quantity)) for quantity, (_, text, _) in columns.items()))
        for result in compared.results
    ]
    for part in ("mean", "std", "lowest", "highest"):
        cells = (_cell(compared.spread[quantity], part, text) for quantity, (_, text, _) in columns.items())
        rows.append((part, *cells))
    headings = (Column("seed", is_text=True), *(Column(heading, spare=spare) for heading, _, spare in columns.values()))
    return Grid(f"{name} on the paper's paths, by seed of the training", headings, tuple(rows))


def _cell(spread: Spread, part: str, text: Callable[[float], str]) -> str:
    value: float | None = getattr(spread, part)
    return "-" if value is None else text(value)
