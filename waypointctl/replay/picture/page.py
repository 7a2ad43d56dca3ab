"""The whole picture of a flight, as a PNG."""

from __future__ import annotations

import textwrap
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from waypointctl.display_text import printable
from waypointctl.figure import FAINT, picture
from waypointctl.log.header import Span
from waypointctl.log.messages import EventKind
from waypointctl.replay.picture.labels import (
    FAILED,
    HOME,
    OPEN,
    OPERATOR,
    REACHED,
    ROBOT,
    STATUS_COLORS,
    UNPROVEN,
    Labels,
    Place,
    short,
)
from waypointctl.replay.picture.path import MANY, draw_path
from waypointctl.replay.picture.sequence import draw_sequence, name_messages
from waypointctl.replay.picture.time_axis import set_time_axis
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.track import FloatArray, IntArray, Track
from waypointctl.units import NS_PER_S, seconds

WIDTH: Final = 1600  # pixels
HEIGHT: Final = 1000
_DPI: Final = 100
_TITLE: Final = 60  # characters of the mission's name
_REASON: Final = 170  # of the outcome, a line
_REASON_LINES: Final = 2
_STYLE: Final[dict[Any, Any]] = {"axes.titlesize": 11, "font.size": 10}


def draw(summary: FlightSummary, title: str, proof: str, *, is_exact: bool) -> bytes:
    """Return the picture of a summary as PNG, WIDTH by HEIGHT pixels; the same summary gives the same bytes.

    Args:
        summary: what to draw.
        title: the mission's name.
        proof: what replay found, for the last line.
        is_exact: whether it found the same flight; if not, the proof is the headline, in red.
    """

    def fill(figure: Figure) -> None:
        _draw_parts(figure, summary)
        _write_heading(figure, summary, title, None if is_exact else proof)
        _write_facts(figure, summary, proof)

    return picture(fill, (WIDTH / _DPI, HEIGHT / _DPI), _DPI, _STYLE)


def _draw_parts(figure: Figure, summary: FlightSummary) -> None:
    grid = figure.add_gridspec(
        2, 2, width_ratios=(1.0, 1.25), left=0.05, right=0.98, top=0.88, bottom=0.135, hspace=0.2
    )
    draw_path(figure.add_subplot(grid[:, 0]), summary)
    speed = figure.add_subplot(grid[0, 1])
    sequence = figure.add_subplot(grid[1, 1], sharex=speed)
    draw_speed(speed, summary)
    draw_sequence(sequence, summary)
    set_time_axis(speed, sequence, summary)
    name_moments(speed, summary)
    name_messages(sequence, summary)


def _write_heading(figure: Figure, summary: FlightSummary, title: str, alarm: str | None) -> None:
    name, outcome = short(title, _TITLE), _wrapped(summary.headline)
    if alarm is None:
        color = REACHED if summary.outcome == "success" else FAILED
        figure.text(0.05, 0.96, name, fontsize=17, fontweight="bold", va="center")
        figure.text(0.05, 0.922, outcome, fontsize=11.5, color=color, va="center")
    else:  # without a verified replay the logged outcome is no headline, and success is not green
        figure.text(0.05, 0.968, alarm.upper(), fontsize=22, fontweight="bold", color=UNPROVEN, va="center")
        logged = _wrapped(f"{name}; logged outcome: {summary.headline}")
        figure.text(0.05, 0.922, logged, fontsize=11.5, va="center")


def _wrapped(text: str) -> str:
    """Return a text in lines broken between words; what is beyond the last line is left out, after a whole word."""
    most = _REASON * _REASON_LINES
    shown = printable(text[: 2 * most], 24 * most)  # room for every escape
    width = _REASON if len(shown) <= _REASON else min(_REASON, len(shown) * 3 // 5)  # no line of one word
    lines = textwrap.wrap(shown, width, max_lines=_REASON_LINES, placeholder=" \N{HORIZONTAL ELLIPSIS}")
    return "\n".join(lines)


def _write_facts(figure: Figure, summary: FlightSummary, proof: str) -> None:
    effort = summary.effort
    facts = [f"distance {effort.distance_m:.1f} m"]
    if effort.mean_speed_mps is not None:
        facts.append(f"{effort.mean_speed_mps:.2f} m/s mean while moving")
    if effort.stopped_share is not None:
        facts.append(f"stopped {effort.stopped_share:.0%} of the time")
    figure.text(0.98, 0.972, ", ".join(facts), fontsize=10.5, ha="right", va="center")
    figure.text(0.98, 0.947, _way_home(summary), fontsize=10.5, color=HOME, ha="right", va="center")
    figure.text(0.98, 0.011, proof, fontsize=8.5, color=OPEN, ha="right", va="center")


def _way_home(summary: FlightSummary) -> str:
    """Return how the last way home went, and how far from home the robot ended; nothing where there was none."""
    if not summary.returns:
        return ""
    number = "way home" if len(summary.returns) == 1 else f"way home {len(summary.returns)}"
    distance = "" if summary.home_distance_m is None else f"; ended {summary.home_distance_m:.2f} m from home"
    return f"{number} {summary.returns[-1]}{distance}"


_WINDOW_NS: Final = NS_PER_S // 2  # of the moving mean: a stride or two
_POINTS: Final = 6000
_HEADROOM: Final = 1.25  # for the names of the waypoints
_LETTERS: Final = 16  # of a name: a longer one would stand in the curves
_GAP: Final = 10  # control steps without a state are a gap in the line
_SHOWN: Final = {EventKind.FALL: "fall", EventKind.WAYPOINT_TIMEOUT: "timeout"}


def draw_speed(axes: Axes, summary: FlightSummary) -> None:
    """Draw the speeds and the legs of a summary over time [s]."""
    _draw_legs(axes, summary)
    truth, mean_mps = _drawn(summary.truth, summary.resting)
    axes.plot(truth.time_ns / NS_PER_S, truth.speed_mps, color=ROBOT, linewidth=0.6, alpha=0.35)
    axes.plot(truth.time_ns / NS_PER_S, mean_mps, color=ROBOT, linewidth=1.8, label="robot, mean of 0.5 s")
    known = summary.belief.newest().thinned(_POINTS)
    axes.step(
        known.known_ns / NS_PER_S,
        known.speed_mps,
        where="post",
        color=OPERATOR,
        linewidth=1.0,
        label="last known to the operator",
    )
    for event in summary.events:
        if event.kind in _SHOWN:
            axes.axvline(seconds(event.time_ns), color=FAILED, linewidth=1.2)
    axes.set(ylabel="speed [m/s]", title="Speed")
    top = max((float(np.nanmax(track.speed_mps)) for track in (truth, known) if len(track)), default=0.0)
    axes.set_ylim(0.0, max(top, 0.1) * _HEADROOM)
    axes.grid(color=FAINT, linewidth=0.4)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, fontsize=9, borderaxespad=0.2)


def name_moments(axes: Axes, summary: FlightSummary) -> None:
    """Write what happened beside its moment, where there is room; the limits of the axes are set by now."""
    labels = Labels(axes)
    moments = [(event.time_ns, _SHOWN[event.kind], FAILED) for event in summary.events if event.kind in _SHOWN]
    for way in summary.returns:
        moments.append((way.began_ns, "way home", HOME))
        if way.ended_ns is not None:
            moments.append((way.ended_ns, str(way.ending), HOME))
    for waypoint in summary.waypoints:
        if waypoint.reached_ns is not None:
            moments.append((waypoint.reached_ns, waypoint.planned.name, STATUS_COLORS[waypoint.status]))
    top_px = float(axes.get_window_extent().y1) - 3
    for time_ns, name, color in moments:
        at_px, _ = labels.pixels(seconds(time_ns), 0.0)
        places = (Place(at_px - 2, top_px, "right", "top"), Place(at_px + 3, top_px, "left", "top"))
        labels.put(short(name, _LETTERS), places, color, rotation=90)


def _draw_legs(axes: Axes, summary: FlightSummary) -> None:
    width = 0.3 if len(summary.waypoints) > MANY else 1.0
    for waypoint in summary.waypoints:
        color = STATUS_COLORS[waypoint.status]
        if waypoint.started_ns is not None:
            _shade(axes, waypoint.started_ns, waypoint.ended_ns, summary.ended_ns, color)
        if waypoint.reached_ns is not None:
            axes.axvline(seconds(waypoint.reached_ns), color=color, linewidth=width)
    for way in summary.returns:
        _shade(axes, way.began_ns, way.ended_ns, summary.ended_ns, HOME)


def _shade(axes: Axes, begin_ns: int, end_ns: int | None, ended_ns: int, color: str) -> None:
    end_s = seconds(ended_ns if end_ns is None else end_ns)
    axes.axvspan(seconds(begin_ns), end_s, color=color, alpha=0.10, linewidth=0)


def _drawn(track: Track, resting: tuple[Span, ...]) -> tuple[Track, FloatArray]:
    """Return the rows of a line and the mean speed at each (n,).

    While physics sleeps the robot stands, so the line is at zero. Any other gap has no line.
    """
    mean_mps = _moving_mean(track)
    if len(track) < 2:
        return track, mean_mps
    steps_ns = np.diff(track.time_ns)
    gaps = np.flatnonzero(steps_ns > _GAP * np.median(steps_ns))
    stride = max(1, -(-len(track) // _POINTS))
    rows = np.unique(np.concatenate([np.arange(0, len(track), stride), gaps, gaps + 1, [len(track) - 1]]))
    after = np.searchsorted(rows, gaps, "right")  # of each gap, where in the rows it is
    filled = np.where(_rests_in(track.time_ns[gaps], track.time_ns[gaps + 1], resting), 0.0, np.nan)
    edges_ns = np.stack([track.time_ns[gaps], track.time_ns[gaps + 1]])
    shown = track.at(rows)

    def with_gaps(values: FloatArray) -> FloatArray:
        return np.asarray(np.insert(values, np.repeat(after, 2), np.repeat(filled, 2)), np.float64)

    time_ns = np.insert(shown.time_ns, np.repeat(after, 2), edges_ns.T.ravel())
    places = (with_gaps(shown.x_m), with_gaps(shown.y_m), with_gaps(shown.speed_mps))
    return Track(time_ns, time_ns, *places), with_gaps(mean_mps[rows])


def _rests_in(begin_ns: IntArray, end_ns: IntArray, resting: tuple[Span, ...]) -> FloatArray:
    """Return for each gap (n,) whether physics slept in it."""
    rests = np.array(resting, np.int64).reshape(-1, 2)
    return np.asarray(np.searchsorted(rests[:, 0], end_ns, "left") > np.searchsorted(rests[:, 1], begin_ns, "right"))


def _moving_mean(track: Track) -> FloatArray:
    """Return the mean speed of the window centred on each row (n,)."""
    total = np.concatenate([[0.0], np.cumsum(track.speed_mps)])
    # The times of an altered log may stand anywhere up to the last int64, in any order.
    times = track.time_ns.astype(np.float64)
    first = np.searchsorted(times, times - _WINDOW_NS // 2, "left")
    last = np.searchsorted(times, times + _WINDOW_NS // 2, "right")
    return np.asarray((total[last] - total[first]) / np.maximum(last - first, 1), np.float64)
