"""A link worked out the slow way, event by event: an oracle that shares no line with the one under test.

A transmitter, a queue of bytes before it and gates that open and close, in whole nanoseconds. Chance is not in it: who
asks says what becomes of each message.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction


@dataclass(frozen=True)
class Gate:
    """A time in which something can be sent, at a rate [bit/s]; None for at once."""

    begin: int
    end: int
    rate: float | None


@dataclass(frozen=True)
class Parcel:
    """A message that is handed over, and what chance has decided of it."""

    number: int
    at: int
    size: int
    copies: int = 1
    jitters: tuple[int, int] = (0, 0)


@dataclass
class SlowLink:
    """What happens to parcels, in the order of time."""

    gates: Sequence[Gate]
    room: int
    delay: int
    ordered: bool
    departed: dict[int, tuple[int, int]] = field(default_factory=dict)  # number -> first and last bit
    refused: dict[int, str] = field(default_factory=dict)
    lost: set[int] = field(default_factory=set)
    arrived: list[tuple[int, int]] = field(default_factory=list)  # (when, number)
    most_waiting: int = 0

    def run(self, parcels: Sequence[Parcel]) -> None:
        """Work through all parcels; time stands still only where nothing can happen."""
        coming = list(parcels)
        queue: list[Parcel] = []
        busy_until = 0
        while coming or queue:
            now = coming[0].at if not queue else self._start(queue[0], max(busy_until, queue[0].at))
            assert now is not None, "what fits in no gate was never let in"
            if coming and coming[0].at < now:
                now = coming[0].at
            # Who departs now makes room before anybody new is looked at.
            while queue and (start := self._start(queue[0], max(busy_until, queue[0].at))) is not None and start <= now:
                busy_until = self._send(queue.pop(0), start)
            if coming and coming[0].at == now:
                parcel = coming.pop(0)
                reason = self._judge(parcel, queue, busy_until)
                if reason:
                    self.refused[parcel.number] = reason
                elif not queue and self._start(parcel, max(busy_until, now)) == now:
                    busy_until = self._send(parcel, now)
                else:
                    queue.append(parcel)
                    self.most_waiting = max(self.most_waiting, sum(each.size for each in queue))
        self.arrived.sort(key=lambda entry: entry[0])  # stable: in the order in which they were sent

    def _judge(self, parcel: Parcel, queue: Sequence[Parcel], busy_until: int) -> str:
        """Say why a parcel is not let in: it would never be sent behind those before it, or there is no room."""
        free = busy_until
        for each in queue:
            start = self._start(each, max(free, each.at))
            assert start is not None
            free = start + self._airtime(each, self._gate(start))
        start = self._start(parcel, max(free, parcel.at))
        if start is None:
            return "no contact"
        waiting = sum(each.size for each in queue)
        return "queue full" if start > parcel.at and waiting + parcel.size > self.room else ""

    def _send(self, parcel: Parcel, start: int) -> int:
        left = start + self._airtime(parcel, self._gate(start))
        self.departed[parcel.number] = (start, left)
        if not parcel.copies:
            self.lost.add(parcel.number)
        for jitter in parcel.jitters[: parcel.copies]:
            when = max(left, left + self.delay + jitter)
            if self.ordered and self.arrived:
                when = max(when, *(earlier for earlier, _ in self.arrived))
            self.arrived.append((when, parcel.number))
        return left

    def _start(self, parcel: Parcel, earliest: int) -> int | None:
        for gate in self.gates:
            start = max(gate.begin, earliest)
            if start < gate.end and start + self._airtime(parcel, gate) <= gate.end:
                return start
        return None

    def _gate(self, start: int) -> Gate:
        return next(gate for gate in self.gates if gate.begin <= start < gate.end)

    @staticmethod
    def _airtime(parcel: Parcel, gate: Gate) -> int:
        return 0 if gate.rate is None else math.ceil(Fraction(parcel.size * 8 * 10**9) / Fraction(gate.rate))
