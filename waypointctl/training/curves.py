"""Learning curves of one recipe, trained with one seed or several."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.paths import write_whole
from waypointctl.training.events import ENOUGH, WINDOW
from waypointctl.training.progress_file import ProgressRow

QUANTITIES: Final = ("success", "fall", "timeout")
CURVES: Final = "curves.csv"
PICTURE: Final = "curves.png"

_COUNTS: Final = {"success": "successes", "fall": "falls", "timeout": "timeouts"}


@dataclass(frozen=True, slots=True)
class Curves:
    """How the episodes of n seeds ended, along the training.

    Attributes:
        seeds: (n,)
        steps: (m,) control steps of all robots, at the end of each rollout that any seed has.
        rates: by quantity (n, m): of the episodes that ended in the last WINDOW rollouts; nan where fewer than ENOUGH
            did, and after a seed's training had ended.
    """

    seeds: tuple[int, ...]
    steps: NDArray[np.int64]
    rates: Mapping[str, NDArray[np.float64]]

    def shared(self, quantity: str) -> NDArray[np.bool_]:
        """Return at which steps (m,) every seed has a rate: only there is a mean one of the same seeds."""
        return np.asarray(~np.isnan(self.rates[quantity]).any(axis=0))


def curves(progress: Mapping[int, Sequence[ProgressRow]]) -> Curves:
    """Return the curves of runs, by seed; each has a row at least."""
    steps = np.unique([row.steps for rows in progress.values() for row in rows])
    rates = {quantity: np.full((len(progress), len(steps)), np.nan) for quantity in QUANTITIES}
    for number, rows in enumerate(progress.values()):
        places = np.searchsorted(steps, [row.steps for row in rows])
        episodes = _windowed([row.episodes for row in rows])
        for quantity, name in _COUNTS.items():
            ended = _windowed([getattr(row, name) for row in rows])
            rates[quantity][number, places] = np.where(episodes >= ENOUGH, ended / np.maximum(episodes, 1), np.nan)
    return Curves(tuple(progress), steps, rates)


def write_curves(folder: Path, recipe: str, progress: Mapping[int, Sequence[ProgressRow]]) -> None:
    """Write the curves of runs, by seed, into a folder: CURVES and PICTURE.

    Raises:
        OutputError: a file cannot be written.
    """
    from waypointctl.training.curves_picture import draw_curves

    found = curves(progress)
    title = f"{recipe}, seed {found.seeds[0]}" if len(found.seeds) == 1 else f"{recipe}, {len(found.seeds)} seeds"
    write_whole(folder / CURVES, curves_csv(found).encode(), "the curves")
    write_whole(folder / PICTURE, draw_curves(found, title), "the picture")


def curves_csv(found: Curves) -> str:
    """Return the curves as a table: a row for each step, each quantity's mean, lowest, highest and every seed's own.

    A cell is empty where there is no rate; mean, lowest and highest are of all seeds or empty.
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    summary = ("mean", "lowest", "highest")
    own = [f"seed_{seed}" for seed in found.seeds]
    writer.writerow(["steps", *(f"{quantity}_{part}" for quantity in QUANTITIES for part in (*summary, *own))])
    for place, step in enumerate(found.steps):
        cells: list[str] = [str(step)]
        for quantity in QUANTITIES:
            column = found.rates[quantity][:, place]
            parts = (column.mean(), column.min(), column.max())  # nan as soon as one is
            cells += ["" if np.isnan(value) else f"{value:.6g}" for value in (*parts, *column)]
        writer.writerow(cells)
    return text.getvalue()


def _windowed(counts: Sequence[int]) -> NDArray[np.int64]:
    """Return the sum of each count and the WINDOW - 1 before it."""
    total = np.concatenate([[0], np.cumsum(counts)])
    last = np.arange(1, len(total))
    return np.asarray(total[last] - total[np.maximum(last - WINDOW, 0)], dtype=np.int64)
