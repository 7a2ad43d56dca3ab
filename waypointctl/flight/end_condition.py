"""When a flight is over.

It goes on until all that was begun on board is over, and the operator has heard of it or cannot hear any more: a plan,
the way home, a hold that ends by itself, a command that is kept for its time or is still under way. Whether anything
goes on is asked of the robot and of the link as they are; what the operator makes of it, of what it has heard alone.
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

DEAF_AFTER: Final = 1000  # frames that tell the same and are all lost: then nobody waits for the next


@dataclass(frozen=True, slots=True)
class EndCondition:
    """Tells whether a flight is over.

    Attributes:
        station: the ground.
        executive: on board.
        news: which frame of telemetry is the first to tell how the robot stands.
        up: the link to the robot.
        down: the link to the ground.
        is_still: whether the robot has stood still for so long at a time [ns] that it rests.
    """

    station: Station
    executive: Executive
    changes: TelemetryChanges
    up: Direction[Any]
    down: Direction[Any]
    is_still: Callable[[int], bool]

    def is_done(self, now_ns: int) -> bool:
        """Return whether the operator has ended the mission, and all that was begun on board is over."""
        return self.station.finished and self._is_quiet(now_ns) and self._is_told(now_ns)

    def is_silent(self, now_ns: int) -> bool:
        """Return whether nothing can happen any more: the robot rests, and nobody sends or hears anything."""
        if not self.is_still(now_ns) or self.station.console_is_open or not self.station.is_idle:
            return False
        if not self._is_quiet(now_ns):
            return False
        if self.station.acts_on_states and not (self.down.is_dead(now_ns) or self.up.is_dead(now_ns)):
            return False
        return self._is_told(now_ns) and not any(isinstance(one, Ack) for _, one in self.down.under_way)

    def _is_quiet(self, now_ns: int) -> bool:
        """Return whether nothing goes on on board, and nothing is under way or will be sent that changes that."""
        executive = self.executive
        if executive.mode is Mode.FALLEN:
            return True
        if executive.plans or any(not isinstance(one, Heartbeat) for _, one in self.up.under_way):
            return False
        gives_up_ns = executive.gives_up_ns
        if gives_up_ns is not None and not self._is_heard_before(now_ns, gives_up_ns):
            return False
        return not (executive.waits_for_ground and self._is_heard(now_ns))

    def _is_heard(self, now_ns: int) -> bool:
        """Return whether the robot will hear from the ground, if only a sign of life."""
        beats = self.station.next_heartbeat_ns is not None and not self.up.is_dead(now_ns)
        return beats or self.up.next_arrival_ns is not None

    def _is_heard_before(self, now_ns: int, time_ns: int) -> bool:
        """Return whether the robot will hear from the ground before a time [ns], unless the link loses it."""
        arrival_ns, next_ns_ = self.up.next_arrival_ns, self.station.next_heartbeat_ns
        if arrival_ns is None and next_ns_ is not None and not self.up.is_dead(now_ns):
            arrival_ns = self.up.latest_arrival_ns(next_ns_, 1)
        return arrival_ns is not None and arrival_ns <= time_ns

    def _is_told(self, now_ns: int) -> bool:
        """Return whether the operator has heard how the robot stands, or cannot hear it any more."""
        if self.changes.reported_in(self.station.reported.telemetry):
            return True
        if not self.down.is_dead(now_ns) and self.changes.newest - self.changes.first < DEAF_AFTER:
            return False
        return not any(isinstance(one, Telemetry) and self.changes.reported_in(one) for _, one in self.down.under_way)
