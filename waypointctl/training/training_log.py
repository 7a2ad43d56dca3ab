"""The records of a training: progress.csv, TensorBoard scalars, and the status for views."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from types import TracebackType
from typing import Self

from torch.utils.tensorboard.writer import SummaryWriter

from waypointctl.errors import OutputError
from waypointctl.training.events import ENOUGH, WINDOW, TrainingStatus
from waypointctl.training.learner import Rollout
from waypointctl.training.progress_file import ProgressFile, ProgressRow
from waypointctl.training.recipe import Recipe


class TrainingLog:
    """The records of one run, continued when it is resumed."""

    def __init__(self, run: Path, recipe: Recipe, steps: int, begun_s: float) -> None:
        """Open the files.

        Args:
            run: the run's folder.
            recipe: that it follows.
            steps: that training continues from; records of later steps are removed.
            begun_s: when training began, on the clock of time.monotonic, earlier sessions included.

        Raises:
            OutputError: a file cannot be written.
            InputError: progress.csv is there and is something else.
        """
        self._recipe = recipe
        self._begun_s = begun_s
        self._progress = ProgressFile(run, steps, tuple(recipe.algorithm.schedules))
        folder = run / "tensorboard"
        try:
            # TensorBoard forgets what a killed session wrote after the checkpoint that training resumes from.
            self._scalars = SummaryWriter(str(folder), purge_step=steps + 1 if steps else None)
        except OSError as error:
            self._progress.close()
            raise OutputError(f"the scalars cannot be written: {error.strerror}", where=str(folder)) from error
        iteration_steps = recipe.algorithm.iteration_steps
        earlier = [row.rollout(iteration_steps) for row in self._progress.rows[-WINDOW:]]
        self._rollouts: deque[Rollout] = deque(earlier, maxlen=WINDOW)
        self._times_s: deque[float] = deque([time.monotonic()], maxlen=WINDOW + 1)

    def add(self, steps: int, rollout: Rollout, metrics: Mapping[str, float]) -> TrainingStatus:
        """Record a rollout and the update that followed it; return the status.

        Args:
            steps: control steps of all robots so far.
            rollout: what the robots did.
            metrics: of the update.
        """
        self._rollouts.append(rollout)
        self._times_s.append(time.monotonic())
        status = self._status(steps)
        self._progress.add(ProgressRow.of(status, rollout))
        scalars = {
            "task/success_rate": status.success_rate,
            "task/fall_rate": status.fall_rate,
            "task/timeout_rate": status.timeout_rate,
            "task/mean_reward": status.mean_reward,
            "time/steps_per_s": status.steps_per_s,
            "train/phase": status.phase,
            **{f"train/{name}": value for name, value in metrics.items()},
        }
        for name, value in scalars.items():
            if value is not None:
                self._scalars.add_scalar(name, value, steps)
        self._scalars.flush()
        return status

    def add_selection(self, steps: int, success_rate: float) -> None:
        """Record the success rate of a checkpoint."""
        self._scalars.add_scalar("selection/success_rate", success_rate, steps)

    def __enter__(self) -> Self:
        """Write."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close the files."""
        self._progress.close()
        self._scalars.close()

    def _status(self, steps: int) -> TrainingStatus:
        recent = Rollout(**{f.name: sum(getattr(one, f.name) for one in self._rollouts) for f in fields(Rollout)})
        timed = list(self._rollouts)[-len(self._times_s) + 1 :]
        span_s = max(self._times_s[-1] - self._times_s[0], 1e-9)
        episodes = recent.episodes if recent.episodes >= ENOUGH else None
        return TrainingStatus(
            steps=steps,
            total_steps=self._recipe.last_step,
            elapsed_s=time.monotonic() - self._begun_s,
            steps_per_s=sum(rollout.steps for rollout in timed) / span_s,
            phase=self._recipe.phase_at(steps)[0],
            episodes=recent.episodes,
            success_rate=recent.successes / episodes if episodes else None,
            fall_rate=recent.falls / episodes if episodes else None,
            timeout_rate=recent.timeouts / episodes if episodes else None,
            mean_reward=recent.reward / recent.steps,
            schedules=self._recipe.schedules_at(steps),
        )
