"""The whole picture of a flight, as a PNG."""

from __future__ import annotations

import textwrap
from typing import Any, Final

from matplotlib.figure import Figure

from waypointctl.display_text import printable
from waypointctl.figure import picture
from waypointctl.replay.picture import palette
from waypointctl.replay.picture.labels import short
from waypointctl.replay.picture.path import draw_path
from waypointctl.replay.picture.sequence import draw_sequence, name_messages
from waypointctl.replay.picture.speed import draw_speed, name_moments
from waypointctl.replay.picture.time_axis import set_time_axis
from waypointctl.replay.summary import FlightSummary

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
        color = palette.REACHED if summary.outcome == "success" else palette.FAILED
        figure.text(0.05, 0.96, name, fontsize=17, fontweight="bold", va="center")
        figure.text(0.05, 0.922, outcome, fontsize=11.5, color=color, va="center")
    else:  # without a verified replay the logged outcome is no headline, and success is not green
        figure.text(0.05, 0.968, alarm.upper(), fontsize=22, fontweight="bold", color=palette.UNPROVEN, va="center")
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
        facts.append(f"{effort.mean_speed_mps:.2f} m/s while walking")
    if effort.standing_share is not None:
        facts.append(f"standing {effort.standing_share:.0%} of the time")
    figure.text(0.98, 0.972, ", ".join(facts), fontsize=10.5, ha="right", va="center")
    figure.text(0.98, 0.947, _way_home(summary), fontsize=10.5, color=palette.HOME, ha="right", va="center")
    figure.text(0.98, 0.011, proof, fontsize=8.5, color=palette.OPEN, ha="right", va="center")


def _way_home(summary: FlightSummary) -> str:
    """Return how the last way home went, and how far from home the robot ended; nothing where there was none."""
    if not summary.returns:
        return ""
    number = "way home" if len(summary.returns) == 1 else f"way home {len(summary.returns)}"
    distance = "" if summary.home_distance_m is None else f"; ended {summary.home_distance_m:.2f} m from home"
    return f"{number} {summary.returns[-1]}{distance}"
