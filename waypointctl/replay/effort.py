"""How the robot spent its time: distance, walking, standing, and when it did what."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from waypointctl.log.messages import Event, EventKind, State
from waypointctl.log.setting import Span
from waypointctl.units import NS_PER_S

_BY_POLICY = ("policy", "ground")  # the policy's actions, computed on board or on the ground


@dataclass(frozen=True, slots=True)
class Effort:
    """How the robot spent its time.

    Attributes:
        distance_m: the way of the torso over ground, standing sway included.
        walked_m: of that, while the policy had the motors.
        walking_ns: the policy had the motors.
        standing_ns: the standing controller had them.
        fallen_ns: they were off.
    """

    distance_m: float
    walked_m: float
    walking_ns: int
    standing_ns: int
    fallen_ns: int

    @property
    def mean_speed_mps(self) -> float | None:
        """The mean speed while walking, None if the robot never walked."""
        return self.walked_m * NS_PER_S / self.walking_ns if self.walking_ns else None

    @property
    def standing_share(self) -> float | None:
        """The share of the time that the robot stood, None if no time went by."""
        total = self.walking_ns + self.standing_ns + self.fallen_ns
        return self.standing_ns / total if total else None


@dataclass(slots=True)
class EffortBuilder:
    """Adds up the way from state to state, by what had the motors.

    Attributes:
        source: of the newest action, as named in the action; empty before the first.
    """

    source: str = ""
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
        walked_m, walking_ns = (sum(each.get(source, 0) for source in _BY_POLICY) for each in (way, time))
        return Effort(sum(way.values()), float(walked_m), int(walking_ns), time.get("stance", 0), time.get("off", 0))
