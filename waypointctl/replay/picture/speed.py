"""Speed over time: the robot's own, and what the operator was told, when it was told."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes

from waypointctl.log.messages import EventKind
from waypointctl.replay.picture import palette
from waypointctl.replay.story import Story
from waypointctl.replay.track import FloatArray, Track
from waypointctl.units import NS_PER_S, seconds

_WINDOW_NS: Final = NS_PER_S // 2  # of the moving mean: a stride or two
_POINTS: Final = 6000
_HEADROOM: Final = 1.25  # for the names of the waypoints
_MOST_NAMES: Final = 20  # above that many waypoints their names would cover each other
_SHOWN: Final = {EventKind.FALL: "fall", EventKind.WAYPOINT_TIMEOUT: "timeout"}


def draw_speed(axes: Axes, story: Story) -> None:
    """Draw the speeds and the legs of a story over time [s]."""
    _draw_legs(axes, story)
    truth = story.truth.thinned(_POINTS)
    mean = np.interp(truth.time_ns, story.truth.time_ns, _moving_mean(story.truth)) if len(truth) else truth.speed_mps
    axes.plot(truth.time_ns / NS_PER_S, truth.speed_mps, color=palette.ROBOT, linewidth=0.6, alpha=0.35)
    axes.plot(truth.time_ns / NS_PER_S, mean, color=palette.ROBOT, linewidth=1.8, label="robot, mean of 0.5 s")
    told = story.belief.thinned(_POINTS)
    axes.step(
        told.known_ns / NS_PER_S,
        told.speed_mps,
        where="post",
        color=palette.OPERATOR,
        linewidth=1.0,
        label="as known to the operator",
    )
    for event in story.events:
        if event.kind in _SHOWN:
            axes.axvline(seconds(event.time_ns), color=palette.FAILED, linewidth=1.2)
            _name(axes, seconds(event.time_ns), _SHOWN[event.kind], palette.FAILED)
    axes.set(ylabel="speed [m/s]", title="Speed")
    top = max((float(np.max(track.speed_mps)) for track in (truth, told) if len(track)), default=0.0)
    axes.set_ylim(0.0, max(top, 0.1) * _HEADROOM)
    axes.grid(color=palette.FAINT, linewidth=0.4)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, fontsize=9, borderaxespad=0.2)


def _draw_legs(axes: Axes, story: Story) -> None:
    for waypoint in story.waypoints:
        if waypoint.started_ns is None:
            continue
        end_ns = story.ended_ns if waypoint.ended_ns is None else waypoint.ended_ns
        color = palette.FATES[waypoint.fate]
        axes.axvspan(seconds(waypoint.started_ns), seconds(end_ns), color=color, alpha=0.10, linewidth=0)
        if waypoint.reached_ns is not None:
            axes.axvline(seconds(waypoint.reached_ns), color=color, linewidth=1.0)
            if len(story.waypoints) <= _MOST_NAMES:
                _name(axes, seconds(waypoint.reached_ns), waypoint.planned.name, color)


def _name(axes: Axes, time_s: float, text: str, color: str) -> None:
    axes.annotate(
        text,
        (time_s, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-2, -3),
        textcoords="offset points",
        rotation=90,
        ha="right",
        va="top",
        fontsize=8,
        color=color,
    )


def _moving_mean(track: Track) -> FloatArray:
    """Return the mean speed of the window centred on each row (n,)."""
    total = np.concatenate([[0.0], np.cumsum(track.speed_mps)])
    # The times of an altered log may stand anywhere up to the last int64, in any order.
    times = track.time_ns.astype(np.float64)
    first = np.searchsorted(times, times - _WINDOW_NS // 2, "left")
    last = np.searchsorted(times, times + _WINDOW_NS // 2, "right")
    return np.asarray((total[last] - total[first]) / np.maximum(last - first, 1), np.float64)
