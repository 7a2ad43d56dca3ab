"""The trajectories of an evaluation, from above, as a PNG; after the paper's Figures 4 and 5."""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Sequence
from typing import Any, Final, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch, Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from waypointctl.evaluation.legend import HOLD_STYLE, TRIAL_STYLE, Regions, draw_legend, legend_of, margin_in
from waypointctl.evaluation.panels import Panel
from waypointctl.evaluation.suite import Hold
from waypointctl.figure import FAINT, GREEN, INK, picture
from waypointctl.mission.fields import Acceptance

FloatArray: TypeAlias = NDArray[np.float64]

_MOST_COLUMNS: Final = 6
_PANEL_IN: Final = 2.9
_SINGLE_IN: Final = 7.0
_LEFT_IN: Final = 0.55
_LETTER_IN: Final = 0.11  # of the heading
_DPI: Final = 110
_PAD_M: Final = 1.5
_STYLE: Final[dict[Any, Any]] = {
    "axes.spines.top": True,
    "axes.spines.right": True,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "font.size": 9,
}


def draw(panels: Sequence[Panel], acceptance: Acceptance, title: str, hold: Hold | None = None) -> bytes:
    """Return the picture of panels as PNG; the same panels give the same bytes.

    Args:
        panels: what to draw.
        acceptance: the region around each waypoint.
        title: what was evaluated.
        hold: how the last waypoint was to be held, if it was.
    """
    columns, rows, size_in = _layout(panels)
    regions = Regions(acceptance, hold)
    legend = legend_of(panels, regions)
    width_in = columns * size_in + 0.3
    below_in = margin_in(legend, width_in)
    height_in = rows * (size_in + 0.35) + below_in + 0.3

    def fill(figure: Figure) -> None:
        grid = figure.add_gridspec(
            rows,
            columns,
            left=_LEFT_IN / width_in,
            right=1 - 0.1 / width_in,
            bottom=below_in / height_in,
            top=1 - 0.8 / height_in,
            hspace=0.32,
            wspace=0.16,
        )
        for index, panel in enumerate(panels):
            axes = figure.add_subplot(grid[index // columns, index % columns])
            _draw_panel(axes, panel, regions, _limits([p for p in panels if p.group == panel.group]))
            _write_over(axes, panel, int(size_in / _LETTER_IN))
        heading = textwrap.fill(title, int(width_in / _LETTER_IN))
        figure.text(_LEFT_IN / width_in, 1 - 0.1 / height_in, heading, fontsize=11, fontweight="bold", va="top")
        draw_legend(figure, legend, _LEFT_IN, is_sample=any(panel.is_sample for panel in panels))

    return picture(fill, (width_in, height_in), _DPI, _STYLE)


def _layout(panels: Sequence[Panel]) -> tuple[int, int, float]:
    """Return columns, rows and the size of a panel [in], so that rows hold whole groups where they can."""
    count = len(panels)
    group = max(Counter(panel.group for panel in panels).values())
    wide = min(_MOST_COLUMNS, math.ceil(math.sqrt(1.5 * count)))
    columns = min(count, _MOST_COLUMNS, group * max(1, wide // group) if group > 1 else wide)
    return columns, math.ceil(count / columns), _PANEL_IN if count > 1 else _SINGLE_IN


def _limits(panels: Sequence[Panel]) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corner (2,) [m] of a square around all that has to be seen.

    A robot that leaves is followed for as far again as the waypoints reach, and no farther.
    """
    trials = [trial for panel in panels for trial in panel.trials]
    places = np.concatenate([np.zeros((1, 2)), *(trial.path for trial in trials)])
    low, high = places.min(axis=0), places.max(axis=0)
    reach = max(float((high - low).max()), 1.0) / 2
    seen = np.concatenate([places, *(trial.trajectory for trial in trials)])
    low, high = np.maximum(seen.min(axis=0), low - reach), np.minimum(seen.max(axis=0), high + reach)
    half = float((high - low).max()) / 2 + _PAD_M
    centre = (low + high) / 2
    return centre - half, centre + half


def _draw_panel(axes: Axes, panel: Panel, regions: Regions, limits: tuple[FloatArray, FloatArray]) -> None:
    _draw_regions(axes, panel, regions)
    many = bool(panel.given) and len(panel.trials) > 30
    for trial in panel.trials:
        color, mark = TRIAL_STYLE[trial.end]
        failed = trial.end != "success"
        alpha = 0.3 if many and not failed else 0.75
        axes.plot(
            *trial.trajectory.T, color=color, linewidth=0.7 if many else 1.0, alpha=alpha, zorder=4 if failed else 3
        )
        if mark:
            face = color if mark == "x" else "white"
            axes.plot(*trial.trajectory[-1], mark, color=color, markerfacecolor=face, markersize=5, zorder=6)
    axes.plot(0.0, 0.0, "o", color="white", markeredgecolor=INK, markersize=5.5, zorder=7)
    low, high = limits
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, integer=True))
    axes.tick_params(labelsize=7.5, length=2, color=FAINT)
    axes.grid(color=FAINT, linewidth=0.35)
    axes.set_axisbelow(True)


def _write_over(axes: Axes, panel: Panel, letters: int) -> None:
    """Write over a panel whose it is; of a name of more than `letters` characters the middle is left out."""
    half = (letters - 1) // 2
    title = panel.title if len(panel.title) <= letters else f"{panel.title[:half]}…{panel.title[-half:]}"
    axes.set_title(title, fontsize=9.5, fontweight="bold", pad=15)
    axes.annotate(
        panel.subtitle, (0.0, 1.0), xycoords="axes fraction", xytext=(0, 4), textcoords="offset points", fontsize=8.5
    )


def _draw_regions(axes: Axes, panel: Panel, regions: Regions) -> None:
    paths = [path.tolist() for path in panel.given or [trial.path for trial in panel.trials]]
    for place in sorted({tuple(point) for path in paths for point in path}):
        axes.add_patch(_region(place, regions.acceptance, filled=bool(panel.given)))
    if regions.hold is not None:
        for place in sorted({tuple(path[-1]) for path in paths}):
            axes.add_patch(Circle(place, regions.hold.within_m, **HOLD_STYLE))


def _region(place: tuple[float, float], acceptance: Acceptance, *, filled: bool) -> Patch:
    (x, y), reach = place, acceptance.size_m
    region: Patch
    if acceptance.shape == "box":
        region = Rectangle((x - reach, y - reach), 2 * reach, 2 * reach)
    else:
        region = Circle((x, y), reach)
    region.set(
        facecolor=f"{GREEN}44" if filled else "none", edgecolor=GREEN, linewidth=0.9 if filled else 0.6, zorder=2
    )
    return region
