"""What happens between PPO's updates: phases, scalars, status, checkpoints, their tests, and the end."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, fields

from stable_baselines3.common.callbacks import BaseCallback

from waypointctl.training.learner import Learner
from waypointctl.training.progress_file import ProgressFile, ProgressRow
from waypointctl.training.status import ENOUGH, WINDOW, CheckpointSaved, TrainingStatus, Watch
from waypointctl.training.testing import Tester
from waypointctl.training.vec_env import Tally


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
        progress: ProgressFile,
        tester: Tester | None,
        refuse_diverged: Callable[[], None],
        interrupted: Callable[[], bool],
        begun_s: float,
    ) -> None:
        """Watch over a learner.

        Args:
            learner: the training.
            watch: told how it goes after every rollout.
            save: writes a checkpoint; the last one at the end of training.
            progress: given a row after every rollout.
            tester: tests checkpoints, where the best one is to be selected.
            refuse_diverged: called after every update; what it raises ends the training without a checkpoint.
            interrupted: asked before every rollout; True ends the training with a checkpoint.
            begun_s: when it began, on the clock of time.monotonic, earlier sessions counted in.
        """
        super().__init__()
        self._learner = learner
        self._watch = watch
        self._save = save
        self._progress = progress
        self._tester = tester
        self._refuse_diverged = refuse_diverged
        self._interrupted = interrupted
        self._begun_s = begun_s
        self._recent = Recent()
        for row in progress.rows[-WINDOW:]:
            self._recent.tallies.append(_tally(row, learner.robots.num_envs * learner.recipe.ppo.rollout_steps))
        self.interrupted = False
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
        self.interrupted = self._interrupted()
        due = self._tester is not None and self._tester.selection.due(self._learner.steps)
        if self.interrupted or due or self._learner.steps >= self._next_checkpoint:
            self._checkpoint()
        if due and not self.interrupted:
            self._test()

    def _on_training_end(self) -> None:
        if not self._ended:
            self.logger.dump(self._learner.steps)
            self._refuse_diverged()
            self._checkpoint()
            self._test()

    @property
    def met(self) -> bool:
        """Whether the success rate is reached at which training is to end."""
        return self._tester is not None and self._tester.selection.met

    @property
    def _ended(self) -> bool:
        """Whether training has come to its end before the recipe's last step."""
        return self.interrupted or self.met

    def _checkpoint(self) -> None:
        self.saved = self._save()
        self._set_next_checkpoint()
        self._watch(self.saved)

    def _test(self) -> None:
        if self._tester is None or self._tester.selection.last_steps == self._learner.steps:
            return
        assert self.saved is not None, "what is tested has been written"
        self.interrupted = not self._tester.test(self.saved)
        if not self.interrupted:
            self.logger.record("selection/success_rate", self._tester.selection.candidates[-1].success_rate)
            self.logger.dump(self._learner.steps)

    def _set_next_checkpoint(self) -> None:
        every = self._learner.recipe.checkpoint_steps
        self._next_checkpoint = (self._learner.steps // every + 1) * every

    def _on_step(self) -> bool:
        return not self._ended

    def _on_rollout_end(self) -> None:
        entropy = self._learner.weigh_entropy()
        tally = self._learner.robots.drain()
        self._recent.add(tally, time.monotonic())
        status = self._status(entropy)
        self._progress.add(_row(status, tally))
        self._record(status)
        self._watch(status)

    def _status(self, entropy: float) -> TrainingStatus:
        learner, tally = self._learner, self._recent.sum()
        phase, _ = learner.recipe.phase_at(learner.steps)
        enough = tally.episodes >= ENOUGH
        return TrainingStatus(
            steps=learner.steps,
            total_steps=learner.recipe.total_steps,
            elapsed_s=time.monotonic() - self._begun_s,
            steps_per_s=self._recent.steps_per_s,
            phase=phase,
            episodes=tally.episodes,
            success_rate=tally.successes / tally.episodes if enough else None,
            fall_rate=tally.falls / tally.episodes if enough else None,
            timeout_rate=tally.timeouts / tally.episodes if enough else None,
            mean_reward=tally.reward / tally.steps,
            learning_rate=learner.recipe.learning_rate_at(learner.steps),
            entropy=entropy,
        )

    def _record(self, status: TrainingStatus) -> None:
        scalars = {
            "task/success_rate": status.success_rate,
            "task/fall_rate": status.fall_rate,
            "task/timeout_rate": status.timeout_rate,
            "task/mean_reward": status.mean_reward,
            "time/steps_per_s": status.steps_per_s,
            "train/phase": status.phase,
            "train/entropy_weight": status.entropy,
        }
        for name, value in scalars.items():
            if value is not None:
                self.logger.record(name, value)
        self.logger.dump(status.steps)


def _row(status: TrainingStatus, tally: Tally) -> ProgressRow:
    return ProgressRow(
        steps=status.steps,
        wall_time_s=round(status.elapsed_s, 1),
        phase=status.phase,
        episodes=tally.episodes,
        successes=tally.successes,
        falls=tally.falls,
        timeouts=tally.timeouts,
        waypoints=tally.waypoints,
        mean_reward=tally.reward / tally.steps,
        learning_rate=status.learning_rate,
        entropy=status.entropy,
    )


def _tally(row: ProgressRow, steps: int) -> Tally:
    counts = {name: getattr(row, name) for name in ("episodes", "successes", "falls", "timeouts", "waypoints")}
    return Tally(**counts, steps=steps, reward=row.mean_reward * steps)
