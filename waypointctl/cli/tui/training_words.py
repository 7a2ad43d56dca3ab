"""How a training is going, in words and one line of blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from waypointctl.training.status import (
    ENOUGH,
    CheckpointSaved,
    CheckpointTested,
    Resumed,
    StartedFrom,
    Threads,
    TrainingStatus,
)

if TYPE_CHECKING:
    from waypointctl.training.selection import Selection

_BLOCKS: Final = "▁▂▃▄▅▆▇█"
_PLAIN_BLOCKS: Final = "_.-=+*#%"


def count(number: float) -> str:
    """Return a number of steps: 512, 11.7 k, 1.97 M."""
    for factor, unit, digits in ((1e9, "G", 2), (1e6, "M", 2), (1e3, "k", 1)):
        if number >= factor:
            return f"{number / factor:.{digits}f} {unit}"
    return f"{number:.0f}"


def span(time_s: float) -> str:
    """Return a time as 2:47 or 1:02:47; one below nothing, as what is left after the last update, as 0:00."""
    minutes, seconds = divmod(max(round(time_s), 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"


def percent(rate: float | None) -> str:
    """Return a rate, or a dash for one that nothing is known of."""
    return "-" if rate is None else f"{rate:.0%}"


def lately(status: TrainingStatus) -> tuple[tuple[str, float | None], ...]:
    """Return the rates of the episodes that ended lately, by name; None as long as too few have."""
    return ("success", status.success_rate), ("fall", status.fall_rate), ("timeout", status.timeout_rate)


def done(status: TrainingStatus) -> float:
    """Return the part of the steps that is done, 1 at most: the last update can overshoot the total."""
    return min(status.steps / status.total_steps, 1.0)


def exact_percent(rate: float) -> str:
    """Return a rate that is near enough to 100 % for its tenths to matter."""
    return f"{rate:.1%}"


def tested(news: CheckpointTested) -> str:
    """Return how a checkpoint did, and the best of them so far."""
    found = f"{exact_percent(news.success_rate)} of {news.trials} at {count(news.steps)}"
    best = "the best" if news.best_steps == news.steps else f"best {exact_percent(news.best_success_rate)}"
    where = "" if news.best_steps == news.steps else f" at {count(news.best_steps)}"
    goal = "" if news.stop_at is None else f", stops at {news.stop_at:.4g}"
    return f"{found}, {best}{where}{goal}"


def started(news: StartedFrom) -> str:
    """Return what a training begins with, and what of it means something else here."""
    if not news.others:
        return f"network, value function and normaliser of {news.policy}"
    changes = ", ".join(f"{old} is now {new}" for old, new in news.others)
    return f"weights of {news.policy}, which saw {news.layout}; in {news.own_layout} {changes}"


def outcome(selection: Selection, total_steps: int) -> str:
    """Return how a training with a selection ended: whether its target was met, and what was chosen."""
    best, plan = selection.best, selection.recipe
    score = f"{exact_percent(best.success_rate)} of {best.trials} trials in {selection.suite_name}, seed {plan.seed}"
    if selection.met:
        return f"target met after {best.steps} steps in {span(best.wall_time_s)}: {score}"
    chosen = f"the checkpoint at step {best.steps} of {selection.last_steps} was chosen: {score}"
    return chosen if plan.stop_at is None else f"target of {plan.stop_at:.4g} not met in {total_steps} steps; {chosen}"


def threads_text(threads: Threads) -> str:
    """Return how many threads a training uses, and why so many."""
    found = f"{threads.physics} of the physics, {threads.torch} of the network"
    if threads.began is not None and threads.began != threads.torch:
        return f"{found}; the run began with {threads.began}, so its weights will not be bit-exact"
    if threads.asked:
        return found
    return f"{found}, {'the default' if threads.began is None else 'as the run began'}"


def resumed_text(news: Resumed) -> str:
    """Return where a training goes on, or that it is complete."""
    at = f"step {news.steps} of {news.total_steps}"
    return f"the training is complete at {at}; nothing is left to train" if news.complete else f"resumed at {at}"


def line(
    news: Threads | Resumed | TrainingStatus | CheckpointSaved | CheckpointTested | StartedFrom, phases: int
) -> str:
    """Return one line; `phases` is how many the recipe has."""
    if isinstance(news, Threads):
        return f"threads    {threads_text(news)}"
    if isinstance(news, Resumed):
        return f"resume     {resumed_text(news)}"
    if isinstance(news, CheckpointSaved):
        return f"checkpoint {news.folder}"
    if isinstance(news, CheckpointTested):
        return f"tested     success {tested(news)}"
    if isinstance(news, StartedFrom):
        return f"start      {started(news)}"
    parts = (
        f"{done(news):6.1%}",
        f"{count(news.steps)} of {count(news.total_steps)} steps",
        f"{count(news.steps_per_s)}/s",
        f"phase {news.phase + 1}/{phases}",
        *(f"{name} {percent(rate)}" for name, rate in lately(news)),
        *([f"of {news.episodes} episodes"] if news.episodes < ENOUGH else ()),
        f"reward {news.mean_reward:.2f}",
        f"rate {news.learning_rate:.1e}",
        f"{span(news.remaining_s)} left",
    )
    return "  ".join(parts)


def sparkline(history: Sequence[tuple[float, float]], columns: int, *, ascii_only: bool) -> str:
    """Return values from 0 to 1 as a row of blocks.

    Args:
        history: (where along the row, 0 to 1; the value), in order; the newest in a column counts.
        columns: of the whole row; what is ahead stays empty.
        ascii_only: draw with characters that every terminal has.
    """
    blocks = _PLAIN_BLOCKS if ascii_only else _BLOCKS
    row = [" "] * columns
    for place, value in history:
        row[min(int(place * columns), columns - 1)] = blocks[min(int(value * len(blocks)), len(blocks) - 1)]
    return "".join(row)
