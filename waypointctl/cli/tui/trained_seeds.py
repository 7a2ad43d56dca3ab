"""What a training with several seeds came to, for people and for machines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from waypointctl.training.recipe_file import RecipeFile
    from waypointctl.training.seeds import SeedsResult


@dataclass(frozen=True, slots=True)
class SeedsTrained:
    """What there is to tell.

    Attributes:
        recipe_file: that was trained by.
        seeds: that were asked for.
        group: the folder of the runs.
        complete: the seeds that came to their end.
        compared: what they came to; None as long as not all have.
        complete_before: all of them were trained already.
    """

    recipe_file: RecipeFile
    seeds: list[int]
    group: Path
    complete: list[int]
    compared: SeedsResult | None
    complete_before: bool


def tell_seeds(trained: SeedsTrained, go_on: str, *, stderr: bool) -> None:
    """Print a row for each seed, or, of a training that was interrupted, the command to go on with."""
    import typer

    from waypointctl.cli.console import console
    from waypointctl.cli.tui.seeds import seeds_table
    from waypointctl.display_text import printable
    from waypointctl.training.curves import CURVES, PICTURE
    from waypointctl.training.seeds import RESULTS

    if trained.compared is None:
        typer.echo(f"interrupted with {len(trained.complete)} of {len(trained.seeds)} seeds trained", err=stderr)
        typer.echo(f"  to go on:   {go_on}", err=stderr)
        return
    if trained.complete_before:
        typer.echo(
            f"{printable(trained.group)}: every seed was trained to its end before; nothing is left to train",
            err=stderr,
        )
    table = seeds_table(trained.recipe_file.recipe.name, trained.compared, trained.group / RESULTS)
    console(stderr=stderr).print(table)
    typer.echo(f"{printable(trained.group / PICTURE)}: the learning curves; as numbers in {CURVES}", err=stderr)


def seeds_json(trained: SeedsTrained) -> str:
    """Return the JSON object of `waypointctl train --seeds --json`."""
    import json

    from waypointctl.training.curves import CURVES, PICTURE

    group, compared = trained.group, trained.compared
    found = {
        "recipe": trained.recipe_file.recipe.name,
        "recipe_sha256": trained.recipe_file.sha256,
        "outcome": "interrupted" if compared is None else "complete",
        "folder": str(group),
        "asked": trained.seeds,
        "complete_before": trained.complete_before,
        "curves": None if compared is None else str(group / CURVES),
        "picture": None if compared is None else str(group / PICTURE),
        **({"seeds": [], "spread": {}} if compared is None else compared.to_dict()),
    }
    return f"{json.dumps(found, indent=2)}\n"
