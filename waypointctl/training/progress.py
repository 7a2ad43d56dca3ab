"""How a training goes: progress.csv with a row for each rollout of all sessions, TensorBoard scalars, the status."""

from __future__ import annotations

import csv
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from io import StringIO
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

from waypointctl.errors import InputError, OutputError
from waypointctl.input_file import NOT_THERE, read_input
from waypointctl.paths import write_whole
from waypointctl.training.events import ENOUGH, WINDOW, TrainingStatus
from waypointctl.training.learner import Rollout
from waypointctl.training.recipe import Recipe

PROGRESS: Final = "progress.csv"

_LARGEST: Final = 2**26  # [bytes]
_MEND: Final = "Restore the file; or remove it before --resume: a new file begins from there."


@dataclass(frozen=True, slots=True)
class ProgressRow:
    """One rollout.

    Attributes:
        steps: control steps of all robots, this rollout counted in.
        wall_time_s: of the training until then, earlier sessions of a resumed one counted in.
        phase: number of the recipe's phase, from 0.
        episodes: that ended in this rollout, by success, fall or timeout.
        successes: episodes that reached the last waypoint, with the random actions of training.
        falls: episodes that ended so.
        timeouts: episodes that ended so.
        waypoints: reached in this rollout.
        mean_reward: a control step, unscaled.
        schedules: of the update that followed, by name; a column each.
    """

    steps: int
    wall_time_s: float
    phase: int
    episodes: int
    successes: int
    falls: int
    timeouts: int
    waypoints: int
    mean_reward: float
    schedules: dict[str, float] = field(default_factory=dict)

    def rollout(self, steps: int) -> Rollout:
        """Return the rollout, for its number of control steps of all robots."""
        return Rollout(steps=steps, reward=self.mean_reward * steps, **{name: getattr(self, name) for name in _COUNTS})

    def cells(self) -> tuple[object, ...]:
        """Return the row as the file has it."""
        return (*(getattr(self, name) for name in _KINDS), *self.schedules.values())


_COUNTS: Final = ("episodes", "successes", "falls", "timeouts", "waypoints")
_KINDS: Final = {
    each.name: float if each.type == "float" else int for each in fields(ProgressRow) if each.name != "schedules"
}


def read_progress(run: Path) -> list[ProgressRow]:
    """Return the rows of a run's progress.csv; none if there is no file. A last line cut short by a kill is left out.

    Raises:
        InputError: it cannot be read or is something else.
    """
    path = run / PROGRESS
    try:
        text = read_input(path, _LARGEST, within=run).decode()
    except InputError as error:
        if error.problem != NOT_THERE:
            raise
        return []
    except UnicodeDecodeError as error:
        raise InputError(f"cannot be read: {error}", where=str(path)) from error
    whole = text[: text.rfind("\n") + 1]
    try:
        return [_row(cells) for cells in csv.DictReader(StringIO(whole), strict=True)]
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        problem = f"is not the progress of a training: {error}"
        raise InputError(problem, where=str(path), hint=_MEND) from error


def _row(cells: dict[str, str]) -> ProgressRow:
    values: dict[str, Any] = {name: kind(cells[name]) for name, kind in _KINDS.items()}
    return ProgressRow(**values, schedules={name: float(cells[name]) for name in cells if name not in _KINDS})


def _text(rows: list[tuple[object, ...]]) -> str:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


class TrainingLog:
    """The records of one run, continued when it is resumed. Rows leave the process at once: a kill loses none."""

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
        from torch.utils.tensorboard.writer import SummaryWriter  # torch, which progress.csv is read without

        self._recipe = recipe
        self._begun_s = begun_s
        self._path, folder = run / PROGRESS, run / "tensorboard"
        rows = [row for row in read_progress(run) if row.steps <= steps] if steps else []
        header = (*_KINDS, *recipe.algorithm.schedules)
        write_whole(self._path, _text([header, *(row.cells() for row in rows)]).encode(), "the progress")
        try:
            # TensorBoard forgets what a killed session wrote after the checkpoint that training resumes from.
            self._scalars = SummaryWriter(str(folder), purge_step=steps + 1 if steps else None)
        except OSError as error:
            raise OutputError(f"the scalars cannot be written: {error.strerror}", where=str(folder)) from error
        self._file = self._path.open("a", encoding="utf-8", newline="")
        earlier = [row.rollout(recipe.algorithm.iteration_steps) for row in rows[-WINDOW:]]
        self._rollouts: deque[Rollout] = deque(earlier, maxlen=WINDOW)
        self._times_s: deque[float] = deque([time.monotonic()], maxlen=WINDOW + 1)

    def add(self, steps: int, rollout: Rollout, metrics: Mapping[str, float]) -> TrainingStatus:
        """Record a rollout and the update that followed it; return the status.

        Args:
            steps: control steps of all robots so far.
            rollout: what the robots did.
            metrics: of the update.

        Raises:
            OutputError: a file cannot be written.
        """
        self._rollouts.append(rollout)
        self._times_s.append(time.monotonic())
        status = self._status(steps)
        self._write(
            ProgressRow(
                steps=steps,
                wall_time_s=round(status.elapsed_s, 1),
                phase=status.phase,
                mean_reward=rollout.reward / rollout.steps,
                schedules=status.schedules,
                **{name: getattr(rollout, name) for name in _COUNTS},
            )
        )
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
        self._file.close()
        self._scalars.close()

    def _write(self, row: ProgressRow) -> None:
        try:
            self._file.write(_text([row.cells()]))
            self._file.flush()
        except OSError as error:
            raise OutputError(f"cannot be written: {error.strerror}", where=str(self._path)) from error

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
