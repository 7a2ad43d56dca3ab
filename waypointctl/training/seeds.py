"""One recipe trained with several seeds, one after the other: a group of runs, resumed as a whole and compared."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import fmean, stdev
from typing import Any, Final, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, ValidationError

from waypointctl.errors import OutputError, RecipeError
from waypointctl.evaluation.result import EVALUATION, read_evaluation
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.paths import write_whole
from waypointctl.policy.bundle import load_policy
from waypointctl.policy.manifest import MANIFEST
from waypointctl.training.curves import write_curves
from waypointctl.training.progress import PROGRESS, ProgressRow, read_progress
from waypointctl.training.recipe_file import RECIPE, RecipeFile, place_recipe
from waypointctl.training.run_folder import GROUP, newest_checkpoint
from waypointctl.training.selection import SelectionRecipe

RESULTS: Final = "seeds.json"

TrainOne: TypeAlias = Callable[[RecipeFile, Path, bool], bool]  # (recipe, run, resume) -> whether it is finished


class GroupFile(BaseModel):
    """group.json: what every run of the group does, but for its seed."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    recipe_sha256: str
    phase_steps: list[int]
    selection: SelectionRecipe | None
    threads: int = 0  # requested; 0 is the default


def run_of(group: Path, seed: int) -> Path:
    """Return the folder of a seed's run."""
    return group / f"seed-{seed}"


def is_complete(run: Path) -> bool:
    """Return whether a run has its bundle and its evaluation, which is written last."""
    return (run / EVALUATION).is_file()


def begin_group(recipe_file: RecipeFile, group: Path, seeds: Iterable[int], threads: int = 0) -> None:
    """Write down what a group's runs are to do; none may have begun, nor may the folder be another training's.

    Args:
        recipe_file: the recipe of all runs.
        group: the folder of the runs.
        seeds: a run each.
        threads: requested; 0 is the default.

    Raises:
        OutputError: one has, the folder is of another training or a policy, or it cannot be written.
    """
    if any((group / name).exists() for name in (GROUP, MANIFEST)) or newest_checkpoint(group):
        problem = "has an earlier training or policy, whose recipe would be replaced"
        raise OutputError(problem, where=str(group), hint="Use --resume to continue it, or choose another folder.")
    for run in (run_of(group, seed) for seed in seeds):
        if newest_checkpoint(run) or is_complete(run):
            problem = "has the checkpoints of an earlier training"
            raise OutputError(problem, where=str(run), hint="Use --resume to continue it, or choose another folder.")
    recipe = recipe_file.recipe
    plan = GroupFile(
        recipe_sha256=recipe_file.sha256,
        phase_steps=[phase.steps for phase in recipe.phases],
        selection=recipe.selection,
        threads=threads,
    )
    place_recipe(recipe_file, group)
    write_whole(group / GROUP, f"{plan.model_dump_json(indent=2)}\n".encode(), "the plan")


def group_begun_as(recipe_file: RecipeFile, group: Path) -> tuple[RecipeFile, int]:
    """Return the recipe with the steps and the selection that a group began with, and its number of threads.

    Raises:
        RecipeError: the folder is not a group, or is of another recipe.
    """
    try:
        plan = GroupFile.model_validate_json(read_input(group / GROUP, RECORD_FILE, RecipeError, within=group))
    except (RecipeError, ValidationError) as error:
        problem = f"no group of trainings to continue: no readable {GROUP}"
        raise RecipeError(problem, where=str(group), hint="Train without --resume.") from error
    if plan.recipe_sha256 != recipe_file.sha256:
        hint = f"Resume with {group / RECIPE}, the recipe as it was when the group began, or start a new group."
        raise RecipeError(f"the group was made by another recipe than {recipe_file.path}", where=str(group), hint=hint)
    recipe = recipe_file.recipe.with_phase_steps(plan.phase_steps).model_copy(update={"selection": plan.selection})
    return replace(recipe_file, recipe=recipe), plan.threads


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
    """The results of the seeds that were trained to the end, and the spread of each quantity over them."""

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
