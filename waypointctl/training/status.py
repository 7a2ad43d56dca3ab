"""How a training is going, for whoever watches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias

WINDOW: Final = 20  # rollouts that a rate is taken over
ENOUGH: Final = 20  # episodes; of fewer, most of them short because they failed, a rate says little


@dataclass(frozen=True, slots=True)
class TrainingStatus:
    """One look at a training, taken after a rollout.

    Attributes:
        steps: control steps of all robots so far.
        total_steps: in the recipe.
        elapsed_s: wall time of training so far, earlier sessions of a resumed one counted in.
        steps_per_s: lately.
        phase: number of the recipe's phase, from 0.
        episodes: that ended in the last WINDOW rollouts; the rates are of these, and None as long as they are fewer
            than ENOUGH.
        success_rate: of whole courses walked, actions drawn at random as training does.
        fall_rate: of episodes.
        timeout_rate: of episodes.
        mean_reward: a control step, unscaled.
        learning_rate: of the optimiser.
        entropy: weight of the entropy bonus.
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
    learning_rate: float
    entropy: float

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
class CheckpointTesting:
    """A checkpoint is being tested: `ended` of the `trials` of a case have ended."""

    case: str
    ended: int
    trials: int


@dataclass(frozen=True, slots=True)
class CheckpointTested:
    """A checkpoint has been tested, for the selection of the best.

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
class StartedFrom:
    """Training begins with another policy's weights.

    Attributes:
        policy: its name.
        layout: of its observations.
        own_layout: of the observations in this training.
        others: which of the inputs mean something else here: (what it was, what it is now).
    """

    policy: str
    layout: str
    own_layout: str
    others: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Threads:
    """How many threads a training uses.

    Attributes:
        physics: of the simulation; the weights do not depend on it.
        torch: of the network; the weights depend on it in their last bits.
        asked: whether somebody asked for this number; otherwise it is the default, or the resumed run's.
        began: `torch` of the run that is resumed; None for a new run, and where its checkpoint does not say.
    """

    physics: int
    torch: int
    asked: bool
    began: int | None = None


@dataclass(frozen=True, slots=True)
class Resumed:
    """Training goes on from a checkpoint.

    Attributes:
        steps: of the checkpoint.
        total_steps: in the recipe.
        complete: whether nothing is left to train.
    """

    steps: int
    total_steps: int
    complete: bool


News: TypeAlias = (
    Threads | Resumed | TrainingStatus | CheckpointSaved | CheckpointTesting | CheckpointTested | StartedFrom
)
Watch: TypeAlias = Callable[[News], None]
