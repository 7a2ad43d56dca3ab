"""The progress of a training, as events for a view."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias

WINDOW: Final = 20  # rollouts that a rate is taken over
ENOUGH: Final = 20  # episodes; with fewer, most are short because they failed, and a rate is misleading


@dataclass(frozen=True, slots=True)
class TrainingStatus:
    """The state of a training after an update.

    Attributes:
        steps: control steps of all robots so far.
        total_steps: where training ends, in whole rollouts.
        elapsed_s: wall time of training so far, earlier sessions of a resumed one included.
        steps_per_s: over the last WINDOW rollouts.
        phase: number of the recipe's phase, from 0.
        episodes: that ended in the last WINDOW rollouts; the rates are of these, and None as long as they are fewer
            than ENOUGH.
        success_rate: of episodes that reached the last waypoint, with the random actions of training.
        fall_rate: of episodes.
        timeout_rate: of episodes.
        mean_reward: per control step, unscaled.
        schedules: the present values of the algorithm's schedules, by name.
    """

    steps: int
    total_steps: int
    elapsed_s: float
    steps_per_s: float
    phase: int
    episodes: int
    success_rate: float | None
    fall_rate: float | None
    timeout_rate: float | None
    mean_reward: float
    schedules: dict[str, float]

    @property
    def remaining_s(self) -> float:
        """Wall time left at the present speed."""
        return (self.total_steps - self.steps) / max(self.steps_per_s, 1e-9)


@dataclass(frozen=True, slots=True)
class CheckpointSaved:
    """A checkpoint has been written to `folder`."""

    steps: int
    folder: Path


@dataclass(frozen=True, slots=True)
class EvaluationProgress:
    """A policy is being evaluated.

    Attributes:
        suite: its name.
        final: the evaluation of the finished policy; otherwise of a checkpoint, for the selection.
        case: that is being evaluated.
        ended: trials of it that have ended.
        trials: of each case.
    """

    suite: str
    final: bool
    case: str
    ended: int
    trials: int


@dataclass(frozen=True, slots=True)
class CheckpointEvaluated:
    """A checkpoint has been evaluated for the selection.

    Attributes:
        steps: of its training.
        trials: of all cases together.
        success_rate: of these, with deterministic actions.
        best_steps: of the best one so far.
        best_success_rate: of the best one so far.
        stop_at: the success rate that ends the training, if one does.
    """

    steps: int
    trials: int
    success_rate: float
    best_steps: int
    best_success_rate: float
    stop_at: float | None


@dataclass(frozen=True, slots=True)
class WarmStarted:
    """Training begins with another policy's weights.

    Attributes:
        policy: its name.
        layout: of its observations.
        own_layout: of the observations in this training.
        changed: the inputs that have another meaning here: (what it was, what it is now).
    """

    policy: str
    layout: str
    own_layout: str
    changed: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Threads:
    """The numbers of threads that a training uses.

    Attributes:
        physics: of the simulation; the weights do not depend on it.
        torch: of the network; the weights depend on it in their last bits.
        requested: whether this number was given; otherwise it is the default, or the resumed run's.
        began: `torch` of the run that is resumed; None for a new run.
    """

    physics: int
    torch: int
    requested: bool
    began: int | None = None


@dataclass(frozen=True, slots=True)
class Resumed:
    """Training continues from a checkpoint.

    Attributes:
        steps: of the checkpoint.
        total_steps: where training ends, in whole rollouts.
        complete: whether nothing is left to train.
    """

    steps: int
    total_steps: int
    complete: bool


TrainingEvent: TypeAlias = (
    Threads | Resumed | WarmStarted | TrainingStatus | CheckpointSaved | EvaluationProgress | CheckpointEvaluated
)
OnEvent: TypeAlias = Callable[[TrainingEvent], None]
