"""A delay study as a picture: time and share of standing against the round trip, a column for each route."""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator, PercentFormatter

from waypointctl.figure import BLUE, FAINT, GREEN, INK, OCHRE, PURPLE, VERMILION, picture
from waypointctl.studies.case import AUTONOMIES, JOINT
from waypointctl.studies.delay import DelayStudy, Route
from waypointctl.studies.flights import Cell, Estimate

_DPI: Final = 110
_COLUMN_IN: Final = 6.6
_HEIGHT_IN: Final = 8.6
_LINEAR_RATIO: Final = 12.0  # of the longest round trip to the shortest but 0: up to this the axis is linear
_TIME_MARGIN: Final = 1.25  # times the longest mean time, and by the shortest one
_MARGIN: Final = 0.04  # of the axis of round trips, on either side of what was flown
_SPARE_TICK: Final = 0.04  # of the axis: a round trip nearer to the one before it has no label
_LETTER_IN: Final = 0.085  # of the note
_PLOT_STYLES: Final = {
    "mission": (BLUE, "o"),
    "waypoint": (GREEN, "s"),
    "short_range_goal": (VERMILION, "^"),
    "short_range_goal-continuous": (PURPLE, "D"),
    "joint": (OCHRE, "v"),
}
_STYLE: Final[dict[Any, Any]] = {"axes.edgecolor": FAINT, "axes.linewidth": 0.8, "font.size": 9.5}


def draw(study: DelayStudy) -> bytes:
    """Return the picture as PNG; the same study gives the same bytes."""
    size_in = len(study.routes) * _COLUMN_IN + 0.6, _HEIGHT_IN
    return picture(lambda figure: _draw(figure, study, size_in[0]), size_in, _DPI, _STYLE)


def _draw(figure: Figure, study: DelayStudy, width_in: float) -> None:
    count = len(study.routes)
    grid = {"left": 0.75 / width_in, "right": 1 - 0.2 / width_in, "top": 0.86, "bottom": 0.14, "hspace": 0.2}
    axes = figure.subplots(2, count, squeeze=False, gridspec_kw={**grid, "height_ratios": (2, 1), "wspace": 0.14})
    for column, route in enumerate(study.routes):
        _draw_times(axes[0, column], study, route)
        _draw_standing(axes[1, column], study, route)
        for one in axes[:, column]:
            _scale(one, study)
    axes[0, 0].set_ylabel("time until the operator knows [s]")
    axes[1, 0].set_ylabel("share of the time standing")
    _write(figure, study, 0.75 / width_in)


def _draw_times(axes: Axes, study: DelayStudy, route: Route) -> None:
    first_s, last_s = (end(cell.rtt_s for cell in study.cells) for end in (min, max))
    dense_s = first_s + np.linspace(0.0, 1.0, 200) ** 3 * (last_s - first_s)  # dense where the axis is
    times_s = [cell.time_s.value for cell in study.cells if cell.route == route.name and cell.time_s is not None]
    low_s, high_s = (min(times_s) / _TIME_MARGIN, max(times_s) * _TIME_MARGIN) if times_s else (1.0, 10.0)
    axes.set_yscale("log")
    for name, (color, mark) in _PLOT_STYLES.items():
        cells = study.cells_of(route.name, name)
        predicted = [study.predicted_s(route.name, name, float(rtt_s)) for rtt_s in dense_s]
        if cells and AUTONOMIES[name].waits and None not in predicted:
            axes.plot(dense_s, np.array(predicted, float), color=color, linestyle=(0, (4, 3)), linewidth=0.9, alpha=0.8)
        _draw_line(axes, cells, [cell.time_s for cell in cells], (color, mark), (low_s, high_s))
        for cell in cells:
            _mark_failures(axes, cell, color)
    for limit in study.joint_limits:
        if limit.route == route.name and limit.mostly_fails_s is not None:
            _mark_limit(axes, limit.mostly_fails_s)
    axes.set_ylim(low_s, high_s)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_title(f"{route.name}: {route.what}, {route.length_m:.0f} m", fontweight="bold", pad=16)


def _draw_standing(axes: Axes, study: DelayStudy, route: Route) -> None:
    for name, style in _PLOT_STYLES.items():
        cells = study.cells_of(route.name, name)
        _draw_line(axes, cells, [cell.standing_share for cell in cells], style, (0.0, 1.0))
    axes.set_ylim(0.0, 1.02)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel("round trip [s]")


def _draw_line(
    axes: Axes,
    cells: Sequence[Cell],
    estimates: Sequence[Estimate | None],
    style: tuple[str, str],
    limits: tuple[float, float],
) -> None:
    """Draw the successes' means with intervals, which end at the limits of the axis; where few succeed, pale."""
    color, mark = style
    low, high = limits
    shown = [(cell, one) for cell, one in zip(cells, estimates, strict=True) if one is not None]
    for (before, one), (after, other) in itertools.pairwise(shown):
        alpha = 1.0 if before.mostly_succeeds and after.mostly_succeeds else 0.35
        # Straight on the page: between two round trips nothing was flown, and a curve would suggest more.
        axes.plot((before.rtt_s, after.rtt_s), (one.value, other.value), color=color, linewidth=1.5, alpha=alpha)
    for cell, one in shown:
        face, half = color if cell.mostly_succeeds else "white", one.half or 0.0
        ends = [[min(half, max(one.value - low, 0.0))], [min(half, max(high - one.value, 0.0))]]
        axes.errorbar(
            cell.rtt_s, one.value, yerr=ends, color=color, marker=mark, markerfacecolor=face, markersize=5,
            capsize=2.5, linewidth=1.0,
        )  # fmt: skip


def _mark_failures(axes: Axes, cell: Cell, color: str) -> None:
    """Write how many succeeded where not all did, and put a cross above the axes where none did.

    Of `joint` the open marks have to do: in its finer sweep numbers would stand on each other.
    """
    if cell.time_s is None:
        axes.plot(cell.rtt_s, 1.03, "x", color=color, markersize=5, transform=axes.get_xaxis_transform(), clip_on=False)
    elif cell.successes < cell.flights and cell.autonomy != JOINT.name:
        axes.annotate(
            f"{cell.successes}/{cell.flights}", (cell.rtt_s, cell.time_s.value), xytext=(4, -11),
            textcoords="offset points", fontsize=7.5, color=color,
        )  # fmt: skip


def _mark_limit(axes: Axes, rtt_s: float) -> None:
    """Write from which round trip on `joint` fails more often than not."""
    color, _ = _PLOT_STYLES[JOINT.name]
    axes.axvline(rtt_s, color=color, linestyle=":", linewidth=1.2)
    axes.annotate(
        f"joint: fewer than half at {rtt_s:g} s", (rtt_s, 0.96), xycoords=axes.get_xaxis_transform(),
        xytext=(4, 0), textcoords="offset points", fontsize=8, color=color, va="top",
    )  # fmt: skip


def _scale(axes: Axes, study: DelayStudy) -> None:
    """Fit the axis of round trips to those that were flown: all of it is used, however few they are."""
    rtts_s = sorted({cell.rtt_s for cell in study.cells})
    delays_s = [rtt_s for rtt_s in rtts_s if rtt_s > 0]
    decades = math.log10(delays_s[-1] / delays_s[0]) if delays_s else 0.0
    ends_s = [*rtts_s, *(cell.rtt_s for cell in study.joint_sweep)]
    if decades <= math.log10(_LINEAR_RATIO):
        axes.set_xscale("linear")
    elif min(ends_s) > 0:
        axes.set_xscale("log")
    else:  # linear below the shortest delay, so that 0 has a place
        axes.set_xscale("symlog", linthresh=delays_s[0], linscale=decades / 2)
    scale = axes.xaxis.get_transform()
    low, high = scale.transform([min(ends_s), max(ends_s)])
    margin = _MARGIN * (high - low) or 1.0
    axes.set_xlim(*scale.inverted().transform([low - margin, high + margin]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticks(rtts_s, labels=_labels(axes, rtts_s))
    axes.grid(color=FAINT, linewidth=0.35)
    axes.set_axisbelow(True)


def _labels(axes: Axes, rtts_s: Sequence[float]) -> list[str]:
    """Return a label for each round trip, empty where it would stand on the one before."""
    labels, last = [], -1.0
    for rtt_s, place in zip(rtts_s, _places(axes, rtts_s), strict=True):
        spare = place - last < _SPARE_TICK
        labels.append("" if spare else f"{rtt_s:g}")
        last = last if spare else place
    return labels


def _places(axes: Axes, rtts_s: Sequence[float]) -> list[float]:
    """Return where round trips are on their axis, from 0 at its left end to 1 at its right end."""
    scale = axes.xaxis.get_transform()
    low, high = scale.transform(axes.get_xlim())
    return [float(place) for place in (scale.transform(rtts_s) - low) / (high - low)]


def _write(figure: Figure, study: DelayStudy, left: float) -> None:
    drawn = {cell.autonomy for cell in (*study.cells, *study.joint_sweep)}
    handles = [
        Line2D([], [], color=color, marker=mark, markersize=5, label=name)
        for name, (color, mark) in _PLOT_STYLES.items()
        if name in drawn
    ]
    if any(study.undelayed_s(route.name) is not None for route in study.routes):
        handles.append(Line2D([], [], color=INK, linestyle=(0, (4, 3)), linewidth=0.9, label="L/v + N (RTT + think)"))
    if any(cell.time_s is None for cell in (*study.cells, *study.joint_sweep)):
        handles.append(Line2D([], [], color=INK, marker="x", linestyle="none", label="no success"))
    figure.legend(handles=handles, loc="lower center", ncols=4, frameon=False, fontsize=9)
    seeds = f"{len(study.seeds)} seeds each" if len(study.seeds) > 1 else f"seed {study.seeds[0]}"
    thinks = " and ".join(f"{think_s:g}" for think_s in dict.fromkeys(route.think_s for route in study.routes))
    think = f", think time {thinks} s" if thinks != "0" else ""
    figure.text(left, 0.972, f"What a delay costs: {study.policy}", fontsize=13, fontweight="bold", va="center")
    marks = "beside a mark: successes of all flights, where one failed; open mark: fewer than half succeeded"
    note = f"{seeds}{think}; means of the successes, 95 % intervals; {marks}"
    lines = textwrap.fill(note, round(figure.get_figwidth() / _LETTER_IN))
    figure.text(left, 0.95, lines, va="top")
