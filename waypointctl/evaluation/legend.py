"""The marks of the picture of evaluations, and its legend below the panels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from waypointctl.evaluation.panels import End, Panel
from waypointctl.evaluation.suite import Hold
from waypointctl.figure import BLUE, GREEN, INK, OCHRE, PURPLE, VERMILION
from waypointctl.mission.fields import Acceptance

Handle: TypeAlias = Line2D | Patch

_FONT_PT: Final = 9
_LETTER_IN: Final = 0.082
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
    """What is drawn around waypoints.

    Attributes:
        acceptance: around each.
        hold: around the last one, where it is to be held.
    """

    acceptance: Acceptance
    hold: Hold | None


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
    widths_in = [_HANDLE_IN + _LETTER_IN * len(str(handle.get_label())) for handle in handles]
    for rows in range(1, len(handles)):
        columns = [widths_in[first : first + rows] for first in range(0, len(handles), rows)]
        if sum(map(max, columns)) <= width_in:
            return rows
    return len(handles)
