"""How a training is going, for whoever watches."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class TrainingStatus:
    """One look at a training, taken after a rollout.

    Attributes:
        steps: control steps of all robots so far.
        total_steps: in the recipe.
        elapsed_s: wall time of training so far, earlier sessions of a resumed one counted in.
        steps_per_s: lately.
        phase: number of the recipe's phase, from 0.
        episodes: that ended lately; the rates are of these and None where there were none.
        success_rate: of whole courses walked, actions drawn at random as training does.
        fall_rate: of episodes.
        timeout_rate: of episodes.
        mean_reward: a control step, unscaled.
        learning_rate: of the optimiser.
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

    @property
    def remaining_s(self) -> float:
        """Wall time left at the present speed."""
        return (self.total_steps - self.steps) / max(self.steps_per_s, 1e-9)


@dataclass(frozen=True, slots=True)
class CheckpointSaved:
    """A checkpoint has been written to `folder`."""

    steps: int
    folder: Path
