"""When a flight is over.

It ends when everything on board is over and the operator knows it or can receive nothing more: a plan, the return home,
a hold that ends by itself, a command that is kept for its time or is still under way. Whether anything is under way is
read from the true state of robot and link; the outcome follows from the operator's knowledge alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from waypointctl.flight.executive.executive import Executive
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import Heartbeat
from waypointctl.flight.operator.station import Station
from waypointctl.flight.reporter import TelemetryChanges
from waypointctl.log.messages import Ack, Mode, Telemetry

DEAF_AFTER: Final = 1000  # lost frames with the same content: then the next is not awaited


@dataclass(frozen=True, slots=True)
class EndCondition:
    """Decides whether a flight is over.

    Attributes:
        station: the ground.
        executive: on board.
        changes: which frame of telemetry is the first with the robot's current state.
        up: the link to the robot.
        down: the link to the ground.
        is_still: whether the robot is at rest at a time [ns].
    """

    station: Station
    executive: Executive
    changes: TelemetryChanges
    up: Direction[Any]
    down: Direction[Any]
    is_still: Callable[[int], bool]

    def is_done(self, now_ns: int) -> bool:
        """Return whether the operator has ended the mission, and all that was begun on board is over."""
        return self.station.finished and self._is_quiet(now_ns) and self._is_reported(now_ns)

    def is_silent(self, now_ns: int) -> bool:
        """Return whether nothing more can happen: the robot is at rest, and nothing is sent or received."""
        if not self.is_still(now_ns) or self.station.console_is_open or not self.station.is_idle:
            return False
        if not self._is_quiet(now_ns):
            return False
        if self.station.acts_on_states and not (self.down.is_dead(now_ns) or self.up.is_dead(now_ns)):
            return False
        return self._is_reported(now_ns) and not any(isinstance(one, Ack) for _, one in self.down.under_way)

    def _is_quiet(self, now_ns: int) -> bool:
        """Return whether nothing is active on board, and no message under way or to be sent changes that."""
        executive = self.executive
        if executive.mode is Mode.FALLEN:
            return True
        if executive.plans or any(not isinstance(one, Heartbeat) for _, one in self.up.under_way):
            return False
        gives_up_ns = executive.gives_up_ns
        if gives_up_ns is not None and not self._is_contacted_before(now_ns, gives_up_ns):
            return False
        return not (executive.waits_for_ground and self._is_contacted(now_ns))

    def _is_contacted(self, now_ns: int) -> bool:
        """Return whether any message, if only a heartbeat, will reach the robot."""
        beats = self.station.next_heartbeat_ns is not None and not self.up.is_dead(now_ns)
        return beats or self.up.next_arrival_ns is not None

    def _is_contacted_before(self, now_ns: int, time_ns: int) -> bool:
        """Return whether a message will reach the robot before a time [ns], unless the link loses it."""
        arrival_ns, next_ns_ = self.up.next_arrival_ns, self.station.next_heartbeat_ns
        if arrival_ns is None and next_ns_ is not None and not self.up.is_dead(now_ns):
            arrival_ns = self.up.latest_arrival_ns(next_ns_, 1)
        return arrival_ns is not None and arrival_ns <= time_ns

    def _is_reported(self, now_ns: int) -> bool:
        """Return whether the operator knows the robot's current state, or can no longer receive it."""
        if self.changes.reported_in(self.station.reported.telemetry):
            return True
        if not self.down.is_dead(now_ns) and self.changes.newest - self.changes.first < DEAF_AFTER:
            return False
        return not any(isinstance(one, Telemetry) and self.changes.reported_in(one) for _, one in self.down.under_way)
