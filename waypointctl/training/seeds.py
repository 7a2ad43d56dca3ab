"""Training one recipe with several seeds, one after the other, and comparing what they came to."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeAlias

from waypointctl.errors import RecipeError
from waypointctl.paths import write_whole
from waypointctl.training.curves import write_curves
from waypointctl.training.progress_file import PROGRESS, ProgressRow, read_progress
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import newest_checkpoint
from waypointctl.training.seed_group import is_complete, run_of
from waypointctl.training.seed_result import SeedResult, Spread, seed_result, spreads

RESULTS: Final = "seeds.json"

TrainOne: TypeAlias = Callable[[RecipeFile, Path, bool], bool]  # (recipe, run, resume) -> whether it came to its end


@dataclass(frozen=True, slots=True)
class SeedsResult:
    """What the seeds came to that were trained to the end.

    Attributes:
        results: a seed each.
        spread: by quantity, over the seeds.
    """

    results: tuple[SeedResult, ...]
    spread: dict[str, Spread]

    def to_dict(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {
            "seeds": [asdict(result) for result in self.results],
            "spread": {name: asdict(spread) for name, spread in self.spread.items()},
        }


def train_seeds(
    recipe_file: RecipeFile, seeds: Sequence[int], group: Path, train_one: TrainOne, interrupted: Callable[[], bool]
) -> list[int]:
    """Train with each seed in turn, into run_of(group, seed); return the seeds whose training has come to its end.

    Runs that are complete are left as they are, those that have begun are gone on with.

    Args:
        recipe_file: what to do, but for the seed.
        seeds: different ones.
        group: the folder of the runs.
        train_one: trains one, and returns whether it came to its end.
        interrupted: asked between two seeds; True ends it there.
    """
    complete = []
    for seed in seeds:
        run = run_of(group, seed)
        if not is_complete(run):
            if interrupted():
                break
            one = replace(recipe_file, recipe=recipe_file.recipe.model_copy(update={"seed": seed}))
            if not train_one(one, run, newest_checkpoint(run) is not None):
                break
        complete.append(seed)
    return complete


def compare(recipe_file: RecipeFile, seeds: Sequence[int], group: Path) -> SeedsResult:
    """Compare runs that are complete, and write their curves, a picture of them and the results into the group.

    Raises:
        PolicyError, InputError: something of a run is missing or damaged.
        RecipeError: a run's progress is gone.
        OutputError: the files cannot be written.
    """
    results = tuple(seed_result(run_of(group, seed), seed) for seed in seeds)
    write_curves(group, recipe_file.recipe.name, {seed: _rows(run_of(group, seed)) for seed in seeds})
    compared = SeedsResult(results, spreads(results))
    write_whole(group / RESULTS, f"{json.dumps(compared.to_dict(), indent=2)}\n".encode(), "the results")
    return compared


def _rows(run: Path) -> list[ProgressRow]:
    if rows := read_progress(run):
        return rows
    problem = "has no rows, and the training is complete: its learning curve is lost"
    hint = "Put the file back, or remove the run's folder: with --resume that seed is trained again."
    raise RecipeError(problem, where=str(run / PROGRESS), hint=hint)
