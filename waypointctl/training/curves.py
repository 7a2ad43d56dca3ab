"""Learning curves of one recipe, trained with one seed or several: as a table, and as a picture."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.paths import write_whole
from waypointctl.training.events import ENOUGH, WINDOW
from waypointctl.training.progress import ProgressRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

QUANTITIES: Final = ("success", "fall", "timeout")
CURVES: Final = "curves.csv"
PICTURE: Final = "curves.png"
WIDTH: Final = 1600  # pixels of the picture
HEIGHT: Final = 720

_COUNTS: Final = {"success": "successes", "fall": "falls", "timeout": "timeouts"}
_DPI: Final = 100
_FEW: Final = 10  # seeds that are named
_TITLES: Final = {"success": "Courses completed", "fall": "Episodes that ended in a fall"}
_STYLE: Final[dict[Any, Any]] = {"font.size": 11}


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


def draw_curves(found: Curves, title: str) -> bytes:
    """Return the success and fall rates along the training as PNG, WIDTH by HEIGHT pixels.

    Every seed is a thin line; the mean, thick, and the band from the lowest to the highest go as far as all seeds do.
    """
    from waypointctl.figure import picture

    def fill(figure: Figure) -> None:
        axes = figure.subplots(1, 2, sharex=True, gridspec_kw={"left": 0.055, "right": 0.985, "top": 0.83})
        for one, quantity in zip(axes, _TITLES, strict=True):
            _draw(one, found, quantity)
        figure.text(0.055, 0.945, title, fontsize=17, fontweight="bold", va="center")
        seeds = f"seeds {', '.join(map(str, found.seeds))}; " if 1 < len(found.seeds) <= _FEW else ""
        note = f"{seeds}actions drawn at random, as training does; each point over the last {WINDOW} rollouts"
        figure.text(0.055, 0.9, note, va="center")

    return picture(fill, (WIDTH / _DPI, HEIGHT / _DPI), _DPI, _STYLE)


def _draw(axes: Axes, found: Curves, quantity: str) -> None:
    from matplotlib.ticker import EngFormatter, PercentFormatter

    from waypointctl.figure import GREEN, VERMILION

    rates, steps = found.rates[quantity], found.steps
    color = GREEN if quantity == "success" else VERMILION
    for seed, rate in zip(found.seeds, rates, strict=True):
        has = ~np.isnan(rate)
        axes.plot(steps[has], rate[has], color=color, linewidth=0.9, alpha=0.55, label=_once("each seed", seed, found))
        alone = has.sum() == 1  # no line has one point
        if has.any() and (alone or steps[has][-1] < steps[-1]):  # or this one had come far enough
            axes.plot(steps[has][-1], rate[has][-1], "o", color=color, markersize=5, clip_on=False)
    shared = found.shared(quantity)
    if shared.any() and len(found.seeds) > 1:
        low, high = rates[:, shared].min(axis=0), rates[:, shared].max(axis=0)
        band = f"lowest to highest of {len(found.seeds)} seeds"
        axes.fill_between(steps[shared], low, high, color=color, alpha=0.15, linewidth=0, label=band)
        axes.plot(steps[shared], rates[:, shared].mean(axis=0), color=color, linewidth=2.6, label="mean")
    axes.set_title(_TITLES[quantity])
    axes.set_xlabel("control steps of all robots")
    axes.set_xlim(0, steps[-1])
    axes.set_ylim(0, 1.02)
    axes.xaxis.set_major_formatter(EngFormatter(sep=" "))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.grid(alpha=0.2)
    if np.isnan(rates).all():
        note = f"no rate: fewer than {ENOUGH} episodes ended in any {WINDOW} rollouts"
        axes.text(0.5, 0.5, note, transform=axes.transAxes, ha="center", va="center")
    else:
        axes.legend(loc="best", frameon=False)


def _once(label: str, seed: int, found: Curves) -> str:
    """Return the label for the first seed alone: one line of the legend is for all of them."""
    if len(found.seeds) == 1:
        return f"seed {seed}"
    return label if seed == found.seeds[0] else "_"
