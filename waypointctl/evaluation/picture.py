"""The trajectories of an evaluation, from above, as a PNG; after the paper's Figures 4 and 5."""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from waypointctl.evaluation.panels import End, Panel
from waypointctl.evaluation.suite import Hold
from waypointctl.figure import BLUE, FAINT, GREEN, INK, OCHRE, PURPLE, VERMILION, picture
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


Handle: TypeAlias = Line2D | Patch

_FONT_PT: Final = 9
_LEGEND_LETTER_IN: Final = 0.082
_HANDLE_IN: Final = 0.62  # the sign before a label, and the gap to the next
_ROW_IN: Final = 0.23
_FOOT_IN: Final = 0.24  # the line below
_AXIS_IN: Final = 0.42  # the axes' numbers above
_SAMPLE: Final = "drawn: the first trials, and the first of those that failed"

# The colour of a trajectory, and the mark at its end.
TRIAL_STYLE: Final[dict[End, tuple[str, str]]] = {
    "success": (BLUE, ""),
    "fall": (VERMILION, "x"),
    "time-out": (PURPLE, "s"),
    "strayed": (OCHRE, "D"),
}
HOLD_STYLE: Final[dict[str, Any]] = {
    "facecolor": "none",
    "edgecolor": INK,
    "linestyle": ":",
    "linewidth": 0.8,
    "zorder": 2,
}


@dataclass(frozen=True, slots=True)
class Regions:
    """What is drawn around waypoints."""

    acceptance: Acceptance  # around each
    hold: Hold | None  # around the last one, where it is to be held


def legend_of(panels: Sequence[Panel], regions: Regions) -> list[Handle]:
    """Return the entries of the legend, each with its label."""
    handles: list[Handle] = [
        Line2D([], [], color="white", marker="o", markeredgecolor=INK, linestyle="none", label="start"),
        Patch(facecolor=f"{GREEN}44", edgecolor=GREEN, label=f"acceptance region, {regions.acceptance}"),
    ]
    if (hold := regions.hold) is not None:
        handles.append(Patch(**HOLD_STYLE, label=f"to be held for {hold.time_s:g} s within {hold.within_m:g} m"))
    ends = {trial.end for panel in panels for trial in panel.trials}
    for end, (color, mark) in TRIAL_STYLE.items():
        if end in ends:
            face = color if mark == "x" else "white"
            handles.append(Line2D([], [], color=color, marker=mark or "None", markerfacecolor=face, label=end))
    return handles


def margin_in(handles: Sequence[Handle], width_in: float) -> float:
    """Return the height that is needed below the panels [in] of a picture of this width [in]."""
    return _AXIS_IN + _rows(handles, width_in) * _ROW_IN + _FOOT_IN


def draw_legend(figure: Figure, handles: Sequence[Handle], left_in: float, *, is_sample: bool) -> None:
    """Draw the legend into the margin, from `left_in` on, and state how the trials were chosen if not all are shown."""
    width_in, height_in = figure.get_size_inches()
    columns = math.ceil(len(handles) / _rows(handles, width_in))
    figure.legend(
        handles=handles,
        loc="lower center",
        bbox_to_anchor=(0.5, _FOOT_IN / height_in),
        ncols=columns,
        frameon=False,
        fontsize=_FONT_PT,
        borderaxespad=0,
        borderpad=0,
        columnspacing=1.5,
    )
    foot = 0.06 / height_in
    figure.text(1 - 0.1 / width_in, foot, "x and y in m", fontsize=7.5, ha="right", va="bottom")
    if is_sample:
        figure.text(left_in / width_in, foot, _SAMPLE, fontsize=7.5, va="bottom")


def _rows(handles: Sequence[Handle], width_in: float) -> int:
    """Return the fewest rows in which no column of labels is wider than its share."""
    widths_in = [_HANDLE_IN + _LEGEND_LETTER_IN * len(str(handle.get_label())) for handle in handles]
    for rows in range(1, len(handles)):
        columns = [widths_in[first : first + rows] for first in range(0, len(handles), rows)]
        if sum(map(max, columns)) <= width_in:
            return rows
    return len(handles)
