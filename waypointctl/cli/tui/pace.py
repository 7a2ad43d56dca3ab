"""Keeping simulation time to a multiple of wall time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

from waypointctl.flight.sink import Sink
from waypointctl.log.messages import Message, State
from waypointctl.units import ns, seconds

_NAP_S: Final = 0.05  # how long a wait may go without looking whether it is still wanted


class Pace:
    """Lets simulation time pass at `rate` times wall time. It waits; it cannot make up for slow work.

    Attributes:
        rate: simulated seconds in a second.
    """

    def __init__(self, rate: float, idle: Callable[[float], None] = time.sleep) -> None:
        """Start the clock; `idle` is called with how long to wait [s], and may return sooner."""
        self.rate = rate
        self._idle = idle
        self._simulated_s = 0.0
        self._wall_s = time.monotonic()

    @property
    def now_ns(self) -> int:
        """The simulation time that it is, whether or not the simulation has come to it [ns]."""
        return ns(self._simulated_s + (time.monotonic() - self._wall_s) * self.rate)

    def restart(self, time_ns: int) -> None:
        """Say that now is the simulation time `time_ns`."""
        self._simulated_s, self._wall_s = seconds(time_ns), time.monotonic()

    def change(self, rate: float) -> None:
        """Go on from this moment at another rate."""
        now_s = time.monotonic()
        self._simulated_s += (now_s - self._wall_s) * self.rate
        self._wall_s, self.rate = now_s, rate

    def wait_for(self, time_ns: int, stopped: Callable[[], bool] = lambda: False) -> None:
        """Return when it is time for `time_ns`, or when `stopped` returns True."""
        self._catch_up(time_ns)
        while not stopped():
            left_s = self._wall_s + (seconds(time_ns) - self._simulated_s) / self.rate - time.monotonic()
            if left_s <= 0:
                return
            self._idle(min(left_s, _NAP_S))

    def _catch_up(self, time_ns: int) -> None:
        # Time lost, by slow work or while the process was stopped, is not run after: the picture would jump.
        due_s = self._wall_s + (seconds(time_ns) - self._simulated_s) / self.rate
        if time.monotonic() - due_s > 1.0:
            self.restart(time_ns)


def paced(sink: Sink, pace: Pace, stopped: Callable[[], bool]) -> Sink:
    """Return a sink that lets each control step's messages through no sooner than it is time for them."""

    def let_through(message: Message) -> None:
        if isinstance(message, State):
            pace.wait_for(message.time_ns, stopped)
        sink(message)

    return let_through
