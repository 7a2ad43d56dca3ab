"""What a mission fixes before its flight, and views of the flight show: home, zones, contact windows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.messages import PlannedWaypoint
from waypointctl.mission.onboard import Zone
from waypointctl.units import seconds

IntArray: TypeAlias = NDArray[np.int64]
Span: TypeAlias = tuple[int, int]  # from when to when [ns]


@dataclass(frozen=True, slots=True, eq=False)
class ContactWindows:
    """When something can be sent one way of the link.

    Attributes:
        begin_ns: of each window, (n,), in order.
        end_ns: of each window, (n,).
        period_ns: after this all of them come again; 0 for never.
    """

    begin_ns: IntArray
    end_ns: IntArray
    period_ns: int = 0

    def is_open(self, time_ns: IntArray) -> NDArray[np.bool_]:
        """Tell for each of some times (m,) [ns] whether there is contact."""
        within = time_ns % self.period_ns if self.period_ns else time_ns
        window = np.searchsorted(self.begin_ns, within, "right") - 1
        return (window >= 0) & (within < self.end_ns[np.maximum(window, 0)])

    def change_ns(self, now_ns: int) -> int | None:
        """Return when contact begins or ends next after `now_ns`; None for never again."""
        round_ns = now_ns - now_ns % self.period_ns if self.period_ns else 0
        edges = round_ns + np.sort(np.concatenate([self.begin_ns, self.end_ns]))
        edges = np.concatenate([edges, edges + self.period_ns])
        later = edges[edges > now_ns]
        changes = later[self.is_open(later) != self.is_open(np.array([now_ns]))]  # a window may begin as one ends
        return int(changes[0]) if len(changes) else None

    def state_text(self, now_ns: int) -> str:
        """Return whether there is contact, and until when: "open until 12.50 s"."""
        is_open, change_ns = bool(self.is_open(np.array([now_ns]))[0]), self.change_ns(now_ns)
        until = "from now on" if change_ns is None else f"until {seconds(change_ns):.2f} s"
        return f"{'open' if is_open else 'closed'} {until}"

    def closed(self, until_ns: int, most: int) -> tuple[Span, ...] | None:
        """Return the spans without contact from 0 to `until_ns`; None where there are more than `most` windows."""
        rounds = until_ns // self.period_ns + 1 if self.period_ns else 1
        if rounds * len(self.begin_ns) > most:
            return None
        shifts = range(0, rounds * self.period_ns, self.period_ns) if self.period_ns else (0,)
        edges = [0]
        for shift in shifts:
            for begin_ns, end_ns in zip(self.begin_ns.tolist(), self.end_ns.tolist(), strict=True):
                edges += [begin_ns + shift, end_ns + shift]
        edges.append(max(until_ns, edges[-1]))
        spans = zip(edges[::2], edges[1::2], strict=True)
        return tuple((begin, min(end, until_ns)) for begin, end in spans if begin < min(end, until_ns))


@dataclass(frozen=True, slots=True, eq=False)
class MissionSetting:
    """What a mission fixes before its flight.

    Attributes:
        home: where the robot returns to; None where no mission is known.
        may_return: whether the mission names a home, or a rule or a command that sends the robot there.
        zones: of its geofence.
        up: contact from the operator to the robot; None where there is always contact.
        down: contact from the robot to the operator; likewise.
    """

    home: PlannedWaypoint | None = None
    may_return: bool = False
    zones: tuple[Zone, ...] = ()
    up: ContactWindows | None = None
    down: ContactWindows | None = None

    def home_to_show(self, *, has_returned: bool) -> PlannedWaypoint | None:
        """Return home where it matters: the robot has set out for it, or may do so by the mission's rules."""
        return self.home if has_returned or self.may_return else None

    @property
    def ways(self) -> Mapping[str, ContactWindows | None]:
        """Contact each way, by its name."""
        return {"up": self.up, "down": self.down}
