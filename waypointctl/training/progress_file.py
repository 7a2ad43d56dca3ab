"""progress.csv: a row for each rollout of a run, over all sessions."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field, fields
from io import StringIO
from pathlib import Path
from typing import Any, Final, Self

from waypointctl.errors import InputError, OutputError
from waypointctl.input_file import NOT_THERE, read_input
from waypointctl.paths import write_whole
from waypointctl.training.events import TrainingStatus
from waypointctl.training.learner import Rollout

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

    @classmethod
    def of(cls, status: TrainingStatus, rollout: Rollout) -> Self:
        """Return the row of a rollout; its status has the rates of several."""
        return cls(
            steps=status.steps,
            wall_time_s=round(status.elapsed_s, 1),
            phase=status.phase,
            episodes=rollout.episodes,
            successes=rollout.successes,
            falls=rollout.falls,
            timeouts=rollout.timeouts,
            waypoints=rollout.waypoints,
            mean_reward=rollout.reward / rollout.steps,
            schedules=status.schedules,
        )

    def rollout(self, steps: int) -> Rollout:
        """Return the rollout, for its number of control steps of all robots."""
        counts = {name: getattr(self, name) for name in ("episodes", "successes", "falls", "timeouts", "waypoints")}
        return Rollout(steps=steps, reward=self.mean_reward * steps, **counts)

    def cells(self) -> tuple[object, ...]:
        """Return the row as the file has it."""
        return (*(getattr(self, name) for name in _KINDS), *self.schedules.values())


_KINDS: Final = {
    each.name: float if each.type == "float" else int for each in fields(ProgressRow) if each.name != "schedules"
}


class ProgressFile:
    """A run's progress.csv, being written. Rows leave the process at once: a killed training loses none."""

    def __init__(self, run: Path, steps: int, schedules: tuple[str, ...]) -> None:
        """Keep the rows up to `steps`, from which training continues, and remove later ones.

        Args:
            run: the run's folder.
            steps: that training continues from.
            schedules: their names.

        Raises:
            OutputError: the file cannot be written.
            InputError: it is there and is not what this class writes.
        """
        self._path = run / PROGRESS
        self.rows = [row for row in read_progress(run) if row.steps <= steps] if steps else []
        write_whole(
            self._path, _text([(*_KINDS, *schedules), *(row.cells() for row in self.rows)]).encode(), "the progress"
        )
        self._file = self._path.open("a", encoding="utf-8", newline="")

    def add(self, row: ProgressRow) -> None:
        """Write a row.

        Raises:
            OutputError: it cannot be written.
        """
        self.rows.append(row)
        try:
            self._file.write(_text([row.cells()]))
            self._file.flush()
        except OSError as error:
            raise OutputError(f"cannot be written: {error.strerror}", where=str(self._path)) from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()


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
