"""Where the robot was, or was reported to be, as arrays; and the part of the ground that a map shows."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.header import Span
from waypointctl.log.messages import Event, EventKind, State
from waypointctl.mission.onboard import Zone
from waypointctl.units import NS_PER_S

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_SMALLEST_M: Final = 2.0  # a map is never of less than this
_BEYOND: Final = 0.5  # how far, as a share of the larger side, a map goes beyond the way for the sake of zones
# A hundred times as far as a mission can ask for. An altered log can hold any value.
FARTHEST_M: Final = 1e6


def is_on_map(*values: float) -> bool:
    """Return whether places [m] and speeds [m/s] can be drawn and summed: finite, and at most FARTHEST_M."""
    return all(abs(value) <= FARTHEST_M for value in values)  # not so of a NaN


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where the robot was: one row a control step of the truth, or a frame of telemetry, that is on the map."""

    time_ns: IntArray  # (n,) when it was there
    known_ns: IntArray  # (n,) when it was known: the same again for the truth, the arrival for telemetry
    x_m: FloatArray  # (n,)
    y_m: FloatArray  # (n,)
    speed_mps: FloatArray  # (n,) over ground

    def __len__(self) -> int:
        """Return n."""
        return len(self.time_ns)

    def thinned(self, most: int) -> Track:
        """Return every k-th row and the last one, so that there are no more than `most` + 1."""
        stride = max(1, -(-len(self) // most))
        rows = np.arange(0, len(self), stride)
        if len(rows) and rows[-1] != len(self) - 1:
            rows = np.append(rows, len(self) - 1)
        return self.at(rows)

    def newest(self) -> Track:
        """Return the rows that were news when they became known; without frames that newer ones had overtaken."""
        newest_ns = np.maximum.accumulate(self.time_ns)
        is_news = np.ones(len(self), np.bool_)
        is_news[1:] = newest_ns[1:] > newest_ns[:-1]
        return self.at(np.flatnonzero(is_news))

    def between(self, begin_ns: int, end_ns: int) -> Track:
        """Return the rows from `begin_ns` to `end_ns` [ns], both included."""
        return self.at(np.flatnonzero((self.time_ns >= begin_ns) & (self.time_ns <= end_ns)))

    def nearest(self, times_ns: IntArray) -> Track:
        """Return, for each of `times_ns` (m,), the last row not after it; the first where all are."""
        if not len(self):
            return self
        return self.at(np.maximum(np.searchsorted(self.time_ns, times_ns, "right") - 1, 0))

    def last(self) -> Track:
        """Return the last row; none where there is none."""
        return self.at(np.arange(len(self))[-1:])

    def at(self, rows: IntArray) -> Track:
        """Return the rows of these indices (m,)."""
        return Track(self.time_ns[rows], self.known_ns[rows], self.x_m[rows], self.y_m[rows], self.speed_mps[rows])


class TrackBuilder:
    """Collects the rows of a `Track`."""

    def __init__(self) -> None:
        """Begin empty."""
        self._time_ns, self._known_ns = array("q"), array("q")
        self._x_m, self._y_m, self._speed_mps = array("d"), array("d"), array("d")

    def add(self, time_ns: int, known_ns: int, x_m: float, y_m: float, speed_mps: float) -> None:
        """Add a row."""
        self._time_ns.append(time_ns)
        self._known_ns.append(known_ns)
        self._x_m.append(x_m)
        self._y_m.append(y_m)
        self._speed_mps.append(speed_mps)

    def track(self, most: int | None = None) -> Track:
        """Return a copy of all rows, or of about `most` of them, the last one among them."""
        count = len(self._time_ns)
        rows = slice(None, None, 1 if most is None else max(1, count // most))
        last = slice(count if rows.step == 1 else -1, None)

        def times(values: array[int]) -> IntArray:
            return np.array(values[rows] + values[last], np.int64)

        def numbers(values: array[float]) -> FloatArray:
            return np.array(values[rows] + values[last], np.float64)

        places = (numbers(self._x_m), numbers(self._y_m), numbers(self._speed_mps))
        return Track(times(self._time_ns), times(self._known_ns), *places)


@dataclass(frozen=True, slots=True)
class Extent:
    """A part of the ground: its borders [m]."""

    left_m: float
    right_m: float
    bottom_m: float
    top_m: float


def extent(x_m: FloatArray, y_m: FloatArray, zones: Iterable[Zone] = ()) -> Extent:
    """Return what holds the points x_m, y_m (n,) [m], and of the zones what is near: a large one is cut off."""
    corners = [corner for zone in zones for corner in zone.outline_m]
    across, up = _span(x_m), _span(y_m)
    beyond = _BEYOND * max(across[1] - across[0], up[1] - up[0])
    across = _stretched(across, [x for x, _ in corners], beyond)
    up = _stretched(up, [y for _, y in corners], beyond)
    return Extent(*across, *up)


def _span(values_m: FloatArray) -> tuple[float, float]:
    """Return the least and the largest of some coordinates, at least _SMALLEST_M apart."""
    least, largest = (float(values_m.min()), float(values_m.max())) if len(values_m) else (0.0, 0.0)
    short = max(0.0, _SMALLEST_M - (largest - least)) / 2
    return least - short, largest + short


def _stretched(span: tuple[float, float], corners_m: list[float], beyond_m: float) -> tuple[float, float]:
    """Return a span with the corners in it, as far as they lie at most `beyond_m` outside of it."""
    least, largest = span
    return max(least - beyond_m, min([least, *corners_m])), min(largest + beyond_m, max([largest, *corners_m]))


_BY_POLICY = ("policy", "ground")  # the policy's actions, computed on board or on the ground


@dataclass(frozen=True, slots=True)
class Effort:
    """How the robot spent its time."""

    distance_m: float  # the way of the torso over ground, standing sway included
    moved_m: float  # of that, while the policy had the motors
    moving_ns: int  # the policy had the motors
    stopped_ns: int  # the standing controller had them
    fallen_ns: int  # they were off

    @property
    def mean_speed_mps(self) -> float | None:
        """The mean speed while the policy moved the robot, None if it never did."""
        return self.moved_m * NS_PER_S / self.moving_ns if self.moving_ns else None

    @property
    def stopped_share(self) -> float | None:
        """The share of the time that the robot stood, None if no time went by."""
        total = self.moving_ns + self.stopped_ns + self.fallen_ns
        return self.stopped_ns / total if total else None


@dataclass(slots=True)
class EffortBuilder:
    """Adds up the way from state to state, by what had the motors."""

    source: str = ""  # of the newest action, as named in the action; empty before the first
    _time_ns: dict[str, int] = field(default_factory=dict)
    _way_m: dict[str, float] = field(default_factory=dict)
    _moving: list[Span] = field(default_factory=list)
    _resting: list[Span] = field(default_factory=list)
    _rests_since_ns: int | None = None

    def step(self, before: State, after: State) -> None:
        """Take the way between two successive states that are on the map."""
        if not self.source:
            return
        way_m = math.dist(before.qpos[:2].tolist(), after.qpos[:2].tolist())
        self._time_ns[self.source] = self._time_ns.get(self.source, 0) + after.time_ns - before.time_ns
        self._way_m[self.source] = self._way_m.get(self.source, 0.0) + way_m
        if self.source in _BY_POLICY:
            self._move(before.time_ns, after.time_ns)

    def on_event(self, event: Event) -> None:
        """Take an event: a rest begins or ends."""
        if event.kind is EventKind.REST_STARTED:
            self._rests_since_ns = event.time_ns
        elif event.kind is EventKind.REST_ENDED and self._rests_since_ns is not None:
            self._resting.append((self._rests_since_ns, event.time_ns))
            self._rests_since_ns = None

    def _move(self, begin_ns: int, end_ns: int) -> None:
        if self._moving and self._moving[-1][1] == begin_ns:
            begin_ns = self._moving.pop()[0]
        self._moving.append((begin_ns, end_ns))

    @property
    def moving(self) -> tuple[Span, ...]:
        """When a policy's actions have moved the robot so far."""
        return tuple(self._moving)

    def resting(self, now_ns: int) -> tuple[Span, ...]:
        """Return when physics has slept so far; a rest that has not ended lasts until now."""
        now = () if self._rests_since_ns is None else ((self._rests_since_ns, now_ns),)
        return (*self._resting, *now)

    def effort(self) -> Effort:
        """Return distance and time so far."""
        time, way = self._time_ns, self._way_m
        moved_m, moving_ns = (sum(each.get(source, 0) for source in _BY_POLICY) for each in (way, time))
        return Effort(sum(way.values()), float(moved_m), int(moving_ns), time.get("stance", 0), time.get("off", 0))
