"""The ways that robots walked in an evaluation, from above, as a PNG; after the paper's Figures 4 and 5."""

from __future__ import annotations

import io
import math
import textwrap
import warnings
from collections import Counter
from collections.abc import Sequence
from typing import Any, Final, TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from waypointctl.evaluation.conditions import AcceptanceSpec
from waypointctl.evaluation.panels import End, Panel

FloatArray: TypeAlias = NDArray[np.float64]

_MOST_COLUMNS: Final = 6
_PANEL_IN: Final = 2.9
_SINGLE_IN: Final = 7.0
_MARGIN_IN: Final = 0.75  # below, for the key
_LETTER_IN: Final = 0.11  # of the heading
_DPI: Final = 110
_PAD_M: Final = 1.5
_REGION: Final = "#009E73"
_INK: Final = "#222222"
_FAINT: Final = "#C8C8C8"
# Colours told apart by the colour-blind (Okabe and Ito), and the mark at the end of the way.
_LOOKS: Final[dict[End, tuple[str, str]]] = {
    "success": ("#0072B2", ""),
    "fall": ("#D55E00", "x"),
    "time-out": ("#8E44AD", "s"),
    "strayed": ("#B8860B", "D"),
}
_STYLE: Final[dict[Any, Any]] = {
    "text.parse_math": False,  # a dollar sign in a policy's name is a dollar sign
    "axes.titlelocation": "left",
    "axes.edgecolor": _FAINT,
    "axes.linewidth": 0.8,
    "text.color": _INK,
    "font.size": 9,
}


def draw(panels: Sequence[Panel], acceptance: AcceptanceSpec, title: str) -> bytes:
    """Return the picture of panels as PNG; the same panels give the same bytes.

    Args:
        panels: what to draw.
        acceptance: the region around each waypoint.
        title: what was evaluated.
    """
    columns, rows, size_in = _layout(panels)
    width_in, height_in = columns * size_in + 0.3, rows * (size_in + 0.35) + _MARGIN_IN + 0.3
    with mpl.rc_context(_STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")  # of a script the font lacks: drawn as a box
        figure = Figure(figsize=(width_in, height_in), dpi=_DPI)
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(
            rows,
            columns,
            left=0.55 / width_in,
            right=1 - 0.1 / width_in,
            bottom=_MARGIN_IN / height_in,
            top=1 - 0.8 / height_in,
            hspace=0.32,
            wspace=0.16,
        )
        for index, panel in enumerate(panels):
            axes = figure.add_subplot(grid[index // columns, index % columns])
            _draw_panel(axes, panel, acceptance, _limits([p for p in panels if p.group == panel.group]))
        heading = textwrap.fill(title, int(width_in / _LETTER_IN))
        figure.text(0.55 / width_in, 1 - 0.1 / height_in, heading, fontsize=11, fontweight="bold", va="top")
        _draw_key(figure, {trial.end for panel in panels for trial in panel.trials}, acceptance)
        image = io.BytesIO()
        figure.savefig(image, format="png", dpi=_DPI, metadata={"Software": None})
    return image.getvalue()


def _layout(panels: Sequence[Panel]) -> tuple[int, int, float]:
    """Return columns, rows and the size of a panel [in], so that rows hold whole groups where they can."""
    count = len(panels)
    group = max(Counter(panel.group for panel in panels).values())
    wide = min(_MOST_COLUMNS, math.ceil(math.sqrt(1.5 * count)))
    columns = min(count, _MOST_COLUMNS, group * max(1, wide // group) if group > 1 else wide)
    return columns, math.ceil(count / columns), _PANEL_IN if count > 1 else _SINGLE_IN


def _limits(panels: Sequence[Panel]) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corner (2,) [m] of a square around all that has to be seen.

    A robot that walks away is followed for as far again as the waypoints reach, and no farther.
    """
    trials = [trial for panel in panels for trial in panel.trials]
    places = np.concatenate([np.zeros((1, 2)), *(trial.path for trial in trials)])
    low, high = places.min(axis=0), places.max(axis=0)
    reach = max(float((high - low).max()), 1.0) / 2
    ways = np.concatenate([places, *(trial.way for trial in trials)])
    low, high = np.maximum(ways.min(axis=0), low - reach), np.minimum(ways.max(axis=0), high + reach)
    half = float((high - low).max()) / 2 + _PAD_M
    centre = (low + high) / 2
    return centre - half, centre + half


def _draw_panel(axes: Axes, panel: Panel, acceptance: AcceptanceSpec, limits: tuple[FloatArray, FloatArray]) -> None:
    regions = panel.given or [trial.path for trial in panel.trials]
    places = {tuple(point) for path in regions for point in path.tolist()}
    for place in sorted(places):
        axes.add_patch(_region(place, acceptance, filled=bool(panel.given)))
    many = bool(panel.given) and len(panel.trials) > 30
    for trial in panel.trials:
        color, mark = _LOOKS[trial.end]
        failed = trial.end != "success"
        alpha = 0.3 if many and not failed else 0.75
        axes.plot(*trial.way.T, color=color, linewidth=0.7 if many else 1.0, alpha=alpha, zorder=4 if failed else 3)
        if mark:
            face = color if mark == "x" else "white"
            axes.plot(*trial.way[-1], mark, color=color, markerfacecolor=face, markersize=5, zorder=6)
    axes.plot(0.0, 0.0, "o", color="white", markeredgecolor=_INK, markersize=5.5, zorder=7)
    low, high = limits
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, integer=True))
    axes.tick_params(labelsize=7.5, length=2, color=_FAINT)
    axes.grid(color=_FAINT, linewidth=0.35)
    axes.set_axisbelow(True)
    axes.set_title(panel.title, fontsize=9.5, fontweight="bold", pad=15)
    axes.annotate(
        panel.subtitle, (0.0, 1.0), xycoords="axes fraction", xytext=(0, 4), textcoords="offset points", fontsize=8.5
    )


def _region(place: tuple[float, float], acceptance: AcceptanceSpec, *, filled: bool) -> Patch:
    (x, y), reach = place, acceptance.size_m
    region: Patch
    if acceptance.shape == "box":
        region = Rectangle((x - reach, y - reach), 2 * reach, 2 * reach)
    else:
        region = Circle((x, y), reach)
    region.set(
        facecolor=f"{_REGION}44" if filled else "none", edgecolor=_REGION, linewidth=0.9 if filled else 0.6, zorder=2
    )
    return region


def _draw_key(figure: Figure, ends: set[End], acceptance: AcceptanceSpec) -> None:
    handles: list[Line2D | Patch] = [
        Line2D([], [], color="white", marker="o", markeredgecolor=_INK, linestyle="none", label="start"),
        Patch(facecolor=f"{_REGION}44", edgecolor=_REGION, label=f"acceptance region, {acceptance}"),
    ]
    for end, (color, mark) in _LOOKS.items():
        if end in ends:
            face = color if mark == "x" else "white"
            handles.append(Line2D([], [], color=color, marker=mark or "None", markerfacecolor=face, label=end))
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), frameon=False, fontsize=9)
    figure.text(0.995, 0.008, "x and y in m", fontsize=7.5, ha="right", va="bottom")
