"""The axis of time: as it is, or with long waits shortened, so that what happens between them can be seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

from waypointctl.figure import FAINT
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.track import FloatArray
from waypointctl.units import NS_PER_S, seconds

_LONG_NS: Final = 60 * NS_PER_S  # a shorter wait is never shortened
_LONGER: Final = 2.0  # than all the rest of the flight: so much longer is a wait that is shortened
_WIDTH: Final = 0.25  # of a shortened wait, as a share of the rest
_MOST_WIDTH: Final = 1.0  # of all of them
_TICKS: Final = 12
_ENDING: Final = 1.02  # room after the end
_ROUND: Final = (1.0, 2.0, 5.0, 10.0)
_UNITS_S: Final = ((86400, "d"), (3600, "h"), (60, "min"))


@dataclass(frozen=True, slots=True)
class Wait:
    """A wait that is drawn shorter than it was [s]."""

    begin_s: float
    end_s: float


def waits_in(summary: FlightSummary) -> tuple[Wait, ...]:
    """Return the long waits of a flight: the robot rests, and nothing begins or arrives but regular telemetry."""
    times = np.unique(np.clip(np.array(_happenings(summary), np.int64), 0, max(summary.ended_ns, 0)))
    times = np.union1d(times, summary.truth.time_ns)
    gaps = np.diff(times)
    rest_ns = float(gaps[gaps < _LONG_NS].sum())
    long = np.flatnonzero((gaps >= _LONG_NS) & (gaps > _LONGER * max(rest_ns, NS_PER_S)))
    return tuple(Wait(seconds(int(times[at])), seconds(int(times[at + 1]))) for at in long)


def _happenings(summary: FlightSummary) -> list[int]:
    times = [0, summary.ended_ns, *(event.time_ns for event in summary.events)]
    for command in summary.commands:
        times += [
            command.issued_ns,
            *(ack.issued_ns for ack in command.acks),
            *(ack.received_ns for ack in command.acks),
        ]
        times += [time_ns for time_ns in (command.received_ns, command.ended_ns) if time_ns is not None]
    times += [waypoint.known_ns for waypoint in summary.waypoints if waypoint.known_ns is not None]
    return times


def set_time_axis(upper: Axes, lower: Axes, summary: FlightSummary) -> None:
    """Set the axis of time [s] of two parts of a picture, one above the other, and mark what is drawn shorter."""
    end_s = max(1.0, seconds(summary.ended_ns))
    waits = waits_in(summary)
    if not waits:
        lower.set_xlim(0.0, end_s * _ENDING)
        lower.set_xlabel("simulation time [s]")
        return
    true_s, drawn_s = _knots(waits, end_s)
    margin_s = drawn_s[-1] * (_ENDING - 1.0)
    true_s, drawn_s = np.append(true_s, true_s[-1] + margin_s), np.append(drawn_s, drawn_s[-1] + margin_s)

    def forward(time_s: FloatArray) -> FloatArray:
        return _along(time_s, true_s, drawn_s)

    def backward(time_s: FloatArray) -> FloatArray:
        return _along(time_s, drawn_s, true_s)

    ticks, names = _ticks(waits, end_s, float(drawn_s[-1]) / _TICKS)
    for axes in (upper, lower):
        axes.set_xscale("function", functions=(forward, backward))
        axes.xaxis.set_major_locator(FixedLocator(ticks))
        axes.xaxis.set_major_formatter(FixedFormatter(names))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlim(0.0, float(true_s[-1]))
        for wait in waits:
            axes.axvspan(wait.begin_s, wait.end_s, facecolor="none", edgecolor=FAINT, hatch="////", linewidth=0)
    lower.set_xlabel("simulation time [s]; hatched: waits, drawn shorter")


def _along(values: FloatArray, knots: FloatArray, others: FloatArray) -> FloatArray:
    """Return `values` taken from one scale to the other; both go on evenly beyond their ends."""
    below, above = np.minimum(values - knots[0], 0.0), np.maximum(values - knots[-1], 0.0)
    return np.asarray(np.interp(values, knots, others) + below + above, np.float64)


def _knots(waits: tuple[Wait, ...], end_s: float) -> tuple[FloatArray, FloatArray]:
    """Return times (n,) [s] and where they are drawn (n,), between which the axis is even."""
    rest_s = max(1.0, end_s - sum(wait.end_s - wait.begin_s for wait in waits))
    width_s = rest_s * min(_WIDTH, _MOST_WIDTH / len(waits))
    true_s, drawn_s = [0.0], [0.0]
    for wait in waits:
        begin_s = drawn_s[-1] + wait.begin_s - true_s[-1]
        true_s += [wait.begin_s, wait.end_s]
        drawn_s += [begin_s, begin_s + width_s]
    drawn_s.append(drawn_s[-1] + end_s - true_s[-1])
    true_s.append(end_s)
    keep = np.append(True, np.diff(true_s) > 0)
    return np.array(true_s)[keep], np.array(drawn_s)[keep]


def _ticks(waits: tuple[Wait, ...], end_s: float, apart_s: float) -> tuple[list[float], list[str]]:
    """Return round times between the waits, about `apart_s` apart, and their labels.

    The first after a wait is written in full, those that follow as differences.
    """
    power = 10.0 ** np.floor(np.log10(apart_s))
    step_s = next(step * power for step in _ROUND if step * power >= apart_s)
    ticks, names = [], []
    begins, ends = [0.0, *(wait.end_s for wait in waits)], [*(wait.begin_s for wait in waits), end_s]
    for begin_s, end_s_ in zip(begins, ends, strict=True):
        for number in range(int((end_s_ - begin_s) / step_s + 1e-9) + 1):
            ticks.append(begin_s + number * step_s)
            names.append(f"+{number * step_s:g}" if number and begin_s else _tick(ticks[-1]))
    return ticks, names


def _tick(time_s: float) -> str:
    """Return a time as the axis has it: seconds without their unit, as far as they are few."""
    return f"{time_s:g}" if time_s < 1000 else time_text(time_s)


def time_text(time_s: float) -> str:
    """Return a time in readable units: "12.50 s", "1 h 3 min", "5 d 2.5 s"."""
    if time_s < _UNITS_S[1][0]:
        return f"{time_s:.2f} s"
    parts, left_s = [], round(time_s, 2)
    for size_s, unit in _UNITS_S:
        count, left_s = divmod(left_s, size_s)
        if count:
            parts.append(f"{count:.0f} {unit}")
    if round(left_s, 2):
        parts.append(f"{round(left_s, 2):g} s")
    return " ".join(parts)
