"""What a recipe came to with one seed, and with several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, stdev
from typing import Self

from waypointctl.evaluation.result import EVALUATION, read_evaluation
from waypointctl.policy.bundle import load_policy
from waypointctl.training.progress_file import read_progress


@dataclass(frozen=True, slots=True)
class SeedResult:
    """The policy that one seed led to.

    Attributes:
        seed: of the training.
        run: its folder, with the bundle.
        policy_sha256: of the bundle's manifest.
        steps: that training went on for, in control steps of all robots.
        policy_steps: after which the policy was taken; fewer where an earlier checkpoint was selected.
        wall_time_s: of the training.
        trials: of the final evaluation, all of the paper's cases together.
        success_rate: of these.
        fall_rate: of these.
        timeout_rate: of these.
        spl: success weighted by path length, mean over the cases.
        selection_rate: success rate in the test that the policy was selected by, None if it is the last checkpoint.
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
    """Return what a run that is complete came to.

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
