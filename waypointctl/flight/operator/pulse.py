"""Signs of life, sent again and again while the ground is at work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

from waypointctl.flight.link.direction import Fate
from waypointctl.flight.link.frames import Heartbeat

# Takes a heartbeat on its way at a time [ns]; it is told when the heartbeat arrives, and makes it.
BeatLink: TypeAlias = Callable[[int, Callable[[int], Heartbeat]], Fate]


@dataclass(slots=True)
class Pulse:
    """Beats at a period.

    Attributes:
        uplink: takes a heartbeat on its way.
        period_ns: between two of them; 0 for none.
        next_ns: when the next is due; None for never.
        beats: how many have been sent.
    """

    uplink: BeatLink
    period_ns: int
    next_ns: int | None = field(init=False)
    beats: int = 0

    def __post_init__(self) -> None:
        """Begin a period after mission start, when something else is sent."""
        self.next_ns = self.period_ns or None

    def beat(self, now_ns: int) -> None:
        """Send the heartbeat that is due, if one is."""
        if self.next_ns is None or self.next_ns > now_ns:
            return
        number = self.beats
        self.uplink(now_ns, lambda arrives_ns: Heartbeat(number, now_ns, arrives_ns))
        self.beats += 1
        self.next_ns += self.period_ns
