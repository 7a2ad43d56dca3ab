"""Learning curves as a picture."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, PercentFormatter

from waypointctl.figure import GREEN, VERMILION, picture
from waypointctl.training.curves import Curves
from waypointctl.training.events import ENOUGH, WINDOW

WIDTH: Final = 1600  # pixels
HEIGHT: Final = 720

_DPI: Final = 100
_FEW: Final = 10  # seeds that are named
_COLORS: Final = {"success": GREEN, "fall": VERMILION}
_TITLES: Final = {"success": "Courses completed", "fall": "Episodes that ended in a fall"}
_STYLE: Final[dict[Any, Any]] = {"font.size": 11}


def draw_curves(found: Curves, title: str) -> bytes:
    """Return the success and fall rates along the training as PNG, WIDTH by HEIGHT pixels.

    Every seed is a thin line; the mean, thick, and the band from the lowest to the highest go as far as all seeds do.
    """

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
    rates, color, steps = found.rates[quantity], _COLORS[quantity], found.steps
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
