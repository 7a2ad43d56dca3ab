"""Training one recipe with several seeds, one after the other, and comparing the results."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import fmean, stdev
from typing import Any, Final, Self, TypeAlias

from waypointctl.errors import RecipeError
from waypointctl.evaluation.result import EVALUATION, read_evaluation
from waypointctl.paths import write_whole
from waypointctl.policy.bundle import load_policy
from waypointctl.training.curves import write_curves
from waypointctl.training.progress_file import PROGRESS, ProgressRow, read_progress
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import newest_checkpoint
from waypointctl.training.seed_group import is_complete, run_of

RESULTS: Final = "seeds.json"

TrainOne: TypeAlias = Callable[[RecipeFile, Path, bool], bool]  # (recipe, run, resume) -> whether it is finished


@dataclass(frozen=True, slots=True)
class SeedResult:
    """The policy of one seed.

    Attributes:
        seed: of the training.
        run: its folder, with the bundle.
        policy_sha256: of the bundle's manifest.
        steps: length of the training, in control steps of all robots.
        policy_steps: after which the policy was taken; fewer where an earlier checkpoint was selected.
        wall_time_s: of the training.
        trials: of the final evaluation, all of the paper's cases together.
        success_rate: of these.
        fall_rate: of these.
        timeout_rate: of these.
        spl: success weighted by path length, mean over the cases.
        selection_rate: success rate of the selected checkpoint in the selection, None without a selection.
        target_met: whether that reached the rate at which training was to end, None if there is none.
    """

    seed: int
    run: str
    policy_sha256: str
    steps: int
    policy_steps: int
    wall_time_s: float
    trials: int
    success_rate: float
    fall_rate: float
    timeout_rate: float
    spl: float
    selection_rate: float | None
    target_met: bool | None


@dataclass(frozen=True, slots=True)
class Spread:
    """A quantity over the seeds: `std` is the sample standard deviation, None for a single seed."""

    mean: float
    std: float | None
    lowest: float
    highest: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Self:
        """Return the spread of values, one at least."""
        return cls(fmean(values), stdev(values) if len(values) > 1 else None, min(values), max(values))


def seed_result(run: Path, seed: int) -> SeedResult:
    """Return the result of a complete run.

    Raises:
        PolicyError, InputError: its bundle or its evaluation is missing or damaged.
    """
    policy, cases = load_policy(run), read_evaluation(run / EVALUATION).cases
    record = policy.manifest.training
    trials = sum(case.trials for case in cases)
    rows = read_progress(run)
    chosen = record.selection
    rate = chosen.successes / chosen.trials if chosen else None
    target = chosen.stop_at if chosen else None
    return SeedResult(
        seed=seed,
        run=str(run),
        policy_sha256=policy.sha256,
        steps=chosen.last_step if chosen else record.steps,
        policy_steps=record.steps,
        wall_time_s=rows[-1].wall_time_s if rows else record.wall_time_s,
        trials=trials,
        success_rate=sum(case.successes for case in cases) / trials,
        fall_rate=sum(case.falls for case in cases) / trials,
        timeout_rate=sum(case.timeouts for case in cases) / trials,
        spl=fmean(case.spl for case in cases),
        selection_rate=rate,
        target_met=None if rate is None or target is None else rate >= target,
    )


def spreads(results: Sequence[SeedResult]) -> dict[str, Spread]:
    """Return the spread over the seeds of each quantity that is compared."""
    names = ("success_rate", "fall_rate", "timeout_rate", "spl", "selection_rate", "steps", "wall_time_s")
    values = {name: [getattr(result, name) for result in results] for name in names}
    return {name: Spread.of(found) for name, found in values.items() if None not in found}


@dataclass(frozen=True, slots=True)
class SeedsResult:
    """The results of the seeds that were trained to the end.

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
    """Train with each seed in turn, into run_of(group, seed); return the seeds whose training is finished.

    Complete runs are left as they are, those that have begun are resumed.

    Args:
        recipe_file: the recipe; its seed is replaced.
        seeds: different ones.
        group: the folder of the runs.
        train_one: trains one, and returns whether it is finished.
        interrupted: called between two seeds; True ends the training there.
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
    problem = "has no rows, although the training is complete: its learning curve is lost"
    hint = "Put the file back, or remove the run's folder: with --resume that seed is trained again."
    raise RecipeError(problem, where=str(run / PROGRESS), hint=hint)
