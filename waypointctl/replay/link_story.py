"""What the link did in a flight besides delaying: counts of what it lost, doubled, dropped and let wait, each way.

They come from the log's records of such messages, which name every kind: commands, acknowledgements, telemetry,
heartbeats, states and actions. What was only delayed has no record, so nothing is said of how many were sent.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from waypointctl.log.messages import LinkFate, LinkRecord

_NOT_ARRIVED = (LinkFate.LOST, LinkFate.QUEUE_FULL, LinkFate.NO_CONTACT)


@dataclass(frozen=True, slots=True)
class WayStory:
    """One way of the link.

    Attributes:
        lost: how many messages were lost on the way.
        queue_full: how many were dropped because they had to wait and there was no room.
        no_contact: how many were dropped because no contact was left that they fitted in.
        not_arrived: all these, by kind, such as ("command", 2).
        doubled: how many arrived twice.
        waited: how many were not sent at once, whatever became of them then.
        longest_wait_ns: of these.
    """

    lost: int = 0
    queue_full: int = 0
    no_contact: int = 0
    not_arrived: tuple[tuple[str, int], ...] = ()
    doubled: int = 0
    waited: int = 0
    longest_wait_ns: int = 0

    def __bool__(self) -> bool:
        """Tell whether there is anything to tell."""
        return bool(self.not_arrived or self.doubled or self.waited)


@dataclass(frozen=True, slots=True)
class LinkStory:
    """Both ways of the link."""

    up: WayStory = WayStory()
    down: WayStory = WayStory()


@dataclass(slots=True)
class WayTally:
    """Counts one way's records."""

    fates: Counter[LinkFate] = field(default_factory=Counter)
    not_arrived: Counter[str] = field(default_factory=Counter)
    waited: int = 0
    longest_wait_ns: int = 0

    def add(self, record: LinkRecord) -> None:
        """Take a record."""
        self.fates[record.fate] += 1
        if record.fate in _NOT_ARRIVED:
            self.not_arrived[record.what] += 1
        if record.departs_ns > record.time_ns:
            self.waited += 1
            self.longest_wait_ns = max(self.longest_wait_ns, record.departs_ns - record.time_ns)

    def story(self) -> WayStory:
        """Return the counts so far."""
        return WayStory(
            lost=self.fates[LinkFate.LOST],
            queue_full=self.fates[LinkFate.QUEUE_FULL],
            no_contact=self.fates[LinkFate.NO_CONTACT],
            not_arrived=tuple(sorted(self.not_arrived.items())),
            doubled=self.fates[LinkFate.DOUBLED],
            waited=self.waited,
            longest_wait_ns=self.longest_wait_ns,
        )
