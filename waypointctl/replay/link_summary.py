"""What the link did besides delaying: counts of messages lost, duplicated, dropped and queued, each way.

They come from the log's records of such messages, which name every kind: commands, acknowledgements, telemetry,
heartbeats, states and actions. A message that was only delayed has no record, so the number sent is unknown.
"""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from waypointctl.log.header import IntArray, Span
from waypointctl.log.messages import NOT_DELIVERED, DeliveryOutcome, Event, EventKind, LinkRecord


@dataclass(frozen=True, slots=True)
class LinkDirectionSummary:
    """One way of the link."""

    # of messages, by kind and outcome, such as ("command", "lost")
    counts: Mapping[tuple[str, DeliveryOutcome], int] = field(default_factory=dict)
    waited: int = 0  # how many were queued, whether they arrived or not
    longest_wait_ns: int = 0  # of these
    # when each of those that did not arrive was handed to the link, (n,)
    missing_ns: IntArray = field(default_factory=lambda: np.zeros(0, np.int64), compare=False)

    def count(self, outcome: DeliveryOutcome) -> int:
        """Return how many messages had an outcome."""
        return sum(count for (_, theirs), count in self.counts.items() if theirs == outcome)

    @property
    def undelivered(self) -> dict[tuple[str, DeliveryOutcome], int]:
        """How many messages have not arrived, and will not, by kind and outcome."""
        return {key: count for key, count in self.counts.items() if key[1] in NOT_DELIVERED}

    @property
    def not_arrived(self) -> dict[str, int]:
        """How many messages have not arrived, and will not, by kind."""
        kinds = sorted({kind for kind, _ in self.undelivered})
        return {kind: sum(count for (theirs, _), count in self.undelivered.items() if theirs == kind) for kind in kinds}

    def __bool__(self) -> bool:
        """Return whether any message was lost, duplicated, dropped or queued."""
        return bool(self.not_arrived or self.count(DeliveryOutcome.DUPLICATED) or self.waited)


@dataclass(frozen=True, slots=True)
class LinkSummary:
    """Both ways of the link."""

    up: LinkDirectionSummary = field(default_factory=LinkDirectionSummary)  # from the operator to the robot
    down: LinkDirectionSummary = field(default_factory=LinkDirectionSummary)  # from the robot to the operator
    lost_spans: tuple[Span, ...] = ()  # when the link was lost by the robot's rule

    @property
    def missing_ns(self) -> IntArray:
        """When each message that did not arrive was handed to the link, either way, in order, (n,)."""
        return np.sort(np.concatenate([self.up.missing_ns, self.down.missing_ns]))


@dataclass(slots=True)
class LinkDirectionBuilder:
    """Counts one way's records."""

    counts: Counter[tuple[str, DeliveryOutcome]] = field(default_factory=Counter)
    waited: int = 0
    longest_wait_ns: int = 0
    missing_ns: array[int] = field(default_factory=lambda: array("q"))

    def add(self, record: LinkRecord) -> None:
        """Take a record."""
        self.counts[record.message, record.outcome] += 1
        if record.outcome in NOT_DELIVERED:
            self.missing_ns.append(record.time_ns)
        if record.departs_ns > record.time_ns:
            self.waited += 1
            self.longest_wait_ns = max(self.longest_wait_ns, record.departs_ns - record.time_ns)

    def summary(self) -> LinkDirectionSummary:
        """Return the counts so far."""
        missing_ns = np.array(self.missing_ns, np.int64)
        return LinkDirectionSummary(dict(self.counts), self.waited, self.longest_wait_ns, missing_ns)


@dataclass(slots=True)
class LinkSummaryBuilder:
    """Gathers what the link did."""

    up: LinkDirectionBuilder = field(default_factory=LinkDirectionBuilder)
    down: LinkDirectionBuilder = field(default_factory=LinkDirectionBuilder)
    lost_since_ns: int | None = None  # since when the link is lost by the robot's rule; None while it is not
    _lost_spans: list[Span] = field(default_factory=list)

    def add(self, record: LinkRecord) -> None:
        """Take a record; one of a way that there is not, in an altered log, is left out."""
        if record.direction in ("up", "down"):
            (self.up if record.direction == "up" else self.down).add(record)

    def on_event(self, event: Event) -> None:
        """Take an event: the robot has lost or found the link."""
        if event.kind is EventKind.LINK_LOST and self.lost_since_ns is None:
            self.lost_since_ns = event.time_ns
        elif event.kind is EventKind.LINK_RESTORED and self.lost_since_ns is not None:
            self._lost_spans.append((self.lost_since_ns, event.time_ns))
            self.lost_since_ns = None

    def summary(self, now_ns: int) -> LinkSummary:
        """Return what the link did so far; what has not ended lasts until now."""
        now = () if self.lost_since_ns is None else ((self.lost_since_ns, now_ns),)
        return LinkSummary(self.up.summary(), self.down.summary(), (*self._lost_spans, *now))
