"""progress.csv: how a run went, a row for each rollout, whatever sessions it was trained in."""

from __future__ import annotations

import csv
from dataclasses import astuple, dataclass, fields
from io import StringIO
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

from waypointctl.errors import InputError, OutputError
from waypointctl.input_file import NOT_THERE, read_input
from waypointctl.paths import write_whole

PROGRESS: Final = "progress.csv"

_LARGEST: Final = 2**26  # [bytes]
_MEND: Final = (
    "Put the file back as it was; or, of a training that is to go on, remove it: it is begun again from there."
)


@dataclass(frozen=True, slots=True)
class ProgressRow:
    """One rollout.

    Attributes:
        steps: control steps of all robots, this rollout counted in.
        wall_time_s: of the training until then, earlier sessions of a resumed one counted in.
        phase: number of the recipe's phase, from 0.
        episodes: that ended in this rollout, by success, fall or timeout.
        successes: whole courses walked, actions drawn at random as training does.
        falls: episodes that ended so.
        timeouts: episodes that ended so.
        waypoints: reached in this rollout.
        mean_reward: a control step, unscaled.
        learning_rate: of the update that followed.
        entropy: weight of its entropy bonus.
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
    learning_rate: float
    entropy: float


_KINDS: Final = {field.name: float if field.type == "float" else int for field in fields(ProgressRow)}


class ProgressFile:
    """A run's progress.csv, being written. Rows leave the process at once: a killed training loses none."""

    def __init__(self, run: Path, steps: int) -> None:
        """Keep the rows up to `steps`, from which training goes on, and none of what was trained in vain after it.

        Raises:
            OutputError: the file cannot be written.
            InputError: it is there and is not what this class writes.
        """
        self._path = run / PROGRESS
        self.rows = [row for row in read_progress(run) if row.steps <= steps] if steps else []
        write_whole(self._path, _text([list(_KINDS), *map(astuple, self.rows)]).encode(), "the progress")
        self._file = self._path.open("a", encoding="utf-8", newline="")

    def add(self, row: ProgressRow) -> None:
        """Write a row.

        Raises:
            OutputError: it cannot be written.
        """
        self.rows.append(row)
        try:
            self._file.write(_text([astuple(row)]))
            self._file.flush()
        except OSError as error:
            raise OutputError(f"cannot be written: {error.strerror}", where=str(self._path)) from error

    def __enter__(self) -> Self:
        """Write."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
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
    return ProgressRow(**values)


def _text(rows: list[list[str] | tuple[object, ...]]) -> str:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()
