"""Lines of text and one line of blocks about a training."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from waypointctl.training.events import (
    ENOUGH,
    CheckpointEvaluated,
    CheckpointSaved,
    EvaluationProgress,
    Resumed,
    Threads,
    TrainingEvent,
    TrainingStatus,
    WarmStarted,
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


def duration(time_s: float) -> str:
    """Return a time as 2:47 or 1:02:47; a negative one as 0:00."""
    minutes, seconds = divmod(max(round(time_s), 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"


def percent(rate: float | None) -> str:
    """Return a rate, or a dash for an unknown one."""
    return "-" if rate is None else f"{rate:.0%}"


def rates(status: TrainingStatus) -> tuple[tuple[str, float | None], ...]:
    """Return the rates of the latest episodes, by name; None as long as too few have ended."""
    return ("success", status.success_rate), ("fall", status.fall_rate), ("timeout", status.timeout_rate)


def schedules(status: TrainingStatus) -> str:
    """Return the present values of the schedules that are not zero."""
    return ", ".join(f"{name.replace('_', ' ')} {value:.2e}" for name, value in status.schedules.items() if value)


def exact_percent(rate: float) -> str:
    """Return a rate with tenths of a percent."""
    return f"{rate:.1%}"


def _checkpoint_text(event: CheckpointEvaluated) -> str:
    """Return how a checkpoint did, and the best of them so far."""
    found = f"{exact_percent(event.success_rate)} of {event.trials} at {count(event.steps)}"
    best = "the best" if event.best_steps == event.steps else f"best {exact_percent(event.best_success_rate)}"
    where = "" if event.best_steps == event.steps else f" at {count(event.best_steps)}"
    goal = "" if event.stop_at is None else f", stops at {event.stop_at:.4g}"
    return f"{found}, {best}{where}{goal}"


def _warm_start_text(event: WarmStarted) -> str:
    """Return what a training begins with, and which of its inputs have another meaning here."""
    if not event.changed:
        return f"network, value function and normaliser of {event.policy}"
    changes = ", ".join(f"{old} is now {new}" for old, new in event.changed)
    return f"weights of {event.policy} with observation {event.layout}; in {event.own_layout} {changes}"


def outcome_text(selection: Selection, total_steps: int) -> str:
    """Return how a training with a selection ended: whether its target was met, and what was selected."""
    best, plan = selection.best, selection.recipe
    score = f"{exact_percent(best.success_rate)} of {best.trials} trials in {selection.suite_name}, seed {plan.seed}"
    if selection.met:
        return f"target met after {best.steps} steps in {duration(best.wall_time_s)}: {score}"
    selected = f"the checkpoint at step {best.steps} of {selection.last_steps} was selected: {score}"
    missed = f"target of {plan.stop_at} not met in {total_steps} steps; "
    return selected if plan.stop_at is None else f"{missed}{selected}"


def _threads_text(threads: Threads) -> str:
    """Return the numbers of threads of a training, and where they come from."""
    found = f"{threads.physics} for the physics, {threads.torch} for the network"
    if threads.began is not None and threads.began != threads.torch:
        return f"{found}; the run began with {threads.began}, so its weights will not be bit-exact"
    if threads.requested:
        return found
    return f"{found}, {'the default' if threads.began is None else 'as the run began'}"


def _resumed_text(event: Resumed) -> str:
    """Return where a training continues, or that it is complete."""
    at = f"step {event.steps} of {event.total_steps}"
    return f"the training is complete at {at}; nothing is left to train" if event.complete else f"resumed at {at}"


def row(event: TrainingEvent) -> tuple[str, str]:
    """Return an event other than a status as a label and a text."""
    match event:
        case Threads():
            return "threads", _threads_text(event)
        case Resumed():
            return "resume", _resumed_text(event)
        case WarmStarted():
            return "warm start", _warm_start_text(event)
        case CheckpointSaved():
            return "checkpoint", str(event.folder)
        case CheckpointEvaluated():
            return "selection", _checkpoint_text(event)
        case EvaluationProgress():
            text = f"{event.case}, {event.ended} of {event.trials} trials"
            return ("evaluation", text) if event.final else ("selection", f"evaluating {text}")
    raise AssertionError(event)


def line(event: TrainingEvent, phases: int) -> str:
    """Return an event as one line; `phases` is how many the recipe has."""
    if isinstance(event, TrainingStatus):
        return _status_line(event, phases)
    return "{:<10} {}".format(*row(event))


def _status_line(status: TrainingStatus, phases: int) -> str:
    parts = (
        f"{status.steps / status.total_steps:6.1%}",
        f"{count(status.steps)} of {count(status.total_steps)} steps",
        f"{count(status.steps_per_s)}/s",
        f"phase {status.phase + 1}/{phases}",
        *(f"{name} {percent(rate)}" for name, rate in rates(status)),
        *([f"of {status.episodes} episodes"] if status.episodes < ENOUGH else ()),
        f"reward {status.mean_reward:.2f}",
        schedules(status),
        f"{duration(status.remaining_s)} left",
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
