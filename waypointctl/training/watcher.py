"""What happens between PPO's updates: phases, scalars, status, checkpoints, and the end."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Final, TypeAlias

from stable_baselines3.common.callbacks import BaseCallback

from waypointctl.training.learner import Learner
from waypointctl.training.status import CheckpointSaved, TrainingStatus
from waypointctl.training.vec_env import Tally

Watch: TypeAlias = Callable[[TrainingStatus | CheckpointSaved], None]

WINDOW: Final = 20  # rollouts that "lately" looks back on


@dataclass(slots=True)
class Recent:
    """The tallies of the last rollouts, and how long they took."""

    tallies: deque[Tally] = field(default_factory=lambda: deque(maxlen=WINDOW))
    times_s: deque[float] = field(default_factory=lambda: deque(maxlen=WINDOW + 1))

    def add(self, tally: Tally, now_s: float) -> None:
        """Take one rollout more."""
        self.tallies.append(tally)
        self.times_s.append(now_s)

    def sum(self) -> Tally:
        """Return the tallies added up."""
        return Tally(**{f.name: sum(getattr(tally, f.name) for tally in self.tallies) for f in fields(Tally)})

    @property
    def steps_per_s(self) -> float:
        """Control steps of all robots a second of wall time."""
        if len(self.times_s) < 2:
            return 0.0
        span_s = self.times_s[-1] - self.times_s[0]
        return sum(tally.steps for tally in list(self.tallies)[-len(self.times_s) + 1 :]) / max(span_s, 1e-9)


class Watcher(BaseCallback):
    """Stable-baselines3's callback: asked at every step, told of every rollout."""

    def __init__(
        self,
        learner: Learner,
        *,
        watch: Watch,
        save: Callable[[], CheckpointSaved],
        refuse_diverged: Callable[[], None],
        interrupted: Callable[[], bool],
        begun_s: float,
    ) -> None:
        """Watch over a learner.

        Args:
            learner: the training.
            watch: told how it goes after every rollout.
            save: writes a checkpoint; the last one at the end of training.
            refuse_diverged: called after every update; what it raises ends the training without a checkpoint.
            interrupted: asked before every rollout; True ends the training with a checkpoint.
            begun_s: when it began, on the clock of time.monotonic, earlier sessions counted in.
        """
        super().__init__()
        self._learner = learner
        self._watch = watch
        self._save = save
        self._refuse_diverged = refuse_diverged
        self._interrupted = interrupted
        self._begun_s = begun_s
        self._recent = Recent()
        self.stopped = False  # before the recipe's last step
        self.saved: CheckpointSaved | None = None
        self._next_checkpoint = 0
        self._set_next_checkpoint()

    def _on_training_start(self) -> None:
        self._recent.times_s.append(time.monotonic())

    def _on_rollout_start(self) -> None:
        # Between an update and a rollout: the one moment from which training can go on exactly.
        self.logger.dump(self._learner.steps)
        self._refuse_diverged()
        self._learner.enter_phase()
        self.stopped = self._interrupted()
        if self.stopped or self._learner.steps >= self._next_checkpoint:
            self._checkpoint()

    def _on_training_end(self) -> None:
        if not self.stopped:
            self.logger.dump(self._learner.steps)
            self._refuse_diverged()
            self._checkpoint()

    def _checkpoint(self) -> None:
        self.saved = self._save()
        self._set_next_checkpoint()
        self._watch(self.saved)

    def _set_next_checkpoint(self) -> None:
        every = self._learner.recipe.checkpoint_steps
        self._next_checkpoint = (self._learner.steps // every + 1) * every

    def _on_step(self) -> bool:
        return not self.stopped

    def _on_rollout_end(self) -> None:
        self._recent.add(self._learner.robots.drain(), time.monotonic())
        status = self._status()
        self._record(status)
        self._watch(status)

    def _status(self) -> TrainingStatus:
        learner, tally = self._learner, self._recent.sum()
        phase, _ = learner.recipe.phase_at(learner.steps)
        episodes = tally.episodes
        return TrainingStatus(
            steps=learner.steps,
            total_steps=learner.recipe.total_steps,
            elapsed_s=time.monotonic() - self._begun_s,
            steps_per_s=self._recent.steps_per_s,
            phase=phase,
            episodes=episodes,
            success_rate=tally.successes / episodes if episodes else None,
            fall_rate=tally.falls / episodes if episodes else None,
            timeout_rate=tally.timeouts / episodes if episodes else None,
            mean_reward=tally.reward / tally.steps,
            learning_rate=learner.recipe.learning_rate_at(learner.steps),
        )

    def _record(self, status: TrainingStatus) -> None:
        scalars = {
            "task/success_rate": status.success_rate,
            "task/fall_rate": status.fall_rate,
            "task/timeout_rate": status.timeout_rate,
            "task/mean_reward": status.mean_reward,
            "time/steps_per_s": status.steps_per_s,
            "train/phase": status.phase,
        }
        for name, value in scalars.items():
            if value is not None:
                self.logger.record(name, value)
        self.logger.dump(status.steps)
