"""The life of a command on the ground: sent, sent again while nobody answers, given up.

    QUEUED -> SENT -> (the link: LOST, or it arrives) ... any acknowledgement ... a final one
      ^                  |
      +--- UNKNOWN <-----+  no acknowledgement by when there has to be one: it is sent again under the same id

What the ground cannot know is logged for those who read the log: that a command was lost, by the link's clock.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Clock,
    Command,
    CommandStage,
    Event,
    EventKind,
    Mode,
    Severity,
    Stage,
    Telemetry,
)
from waypointctl.ops.ground.order import Order
from waypointctl.ops.link.direction import NEVER, Fate

UNANSWERED: Final = "no acknowledgement"
_UNDER_WAY: Final = (Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED)
_AT_REST: Final = frozenset({Mode.IDLE, Mode.DONE, Mode.FAILED, Mode.FALLEN})  # no command is under way


# Takes a command on its way at a time [ns]; it is told when the command arrives, and makes it.
Uplink: TypeAlias = Callable[[int, Callable[[int], Command]], Fate]


@dataclass(frozen=True, slots=True)
class Insistence:
    """How hard the ground tries to be heard.

    Attributes:
        acknowledged: whether it waits for acknowledgements at all.
        retries: how often a command is sent again.
        answer_by: told when a command's last bit leaves [ns], says by when it has to be acknowledged [ns]; None for
            never, where no contact is left.
        patience_ns: how long after a frame from a robot at rest a final acknowledgement may still come.
    """

    acknowledged: bool
    retries: int
    answer_by: Callable[[int], int | None]
    patience_ns: int


@dataclass(slots=True)
class _Sent:
    order: Order
    attempt: int = 0
    unanswered: int = 0  # sendings since it was last heard of
    told_ns: int = -1  # when the newest acknowledgement was issued, on the robot's clock
    stage: Stage = Stage.QUEUED  # as the ground believes
    answer_by_ns: int | None = None


@dataclass(slots=True)
class Dispatcher:
    """Gives orders their ids, sends them, and sends them again.

    Attributes:
        uplink: takes a command on its way.
        insistence: how hard to try.
        sink: takes each stage of a command on the ground and on the link, and the events.
    """

    uplink: Uplink
    insistence: Insistence
    sink: Callable[[CommandStage | Event], None]
    _issued: int = 0
    _open: dict[int, _Sent] = field(default_factory=dict)  # by id: no final acknowledgement has been heard
    _agenda: list[tuple[int, int, CommandStage]] = field(default_factory=list)  # a heap: stages to come
    _serial: int = 0
    _deadlines: list[tuple[int, int]] = field(default_factory=list)  # a heap: (answer by, id), some no longer so

    @property
    def wake_ns(self) -> int | None:
        """When there is something to do next [ns]; None for never."""
        while self._deadlines and not self._holds(self._deadlines[0]):
            heapq.heappop(self._deadlines)
        earliest = self._agenda[0][0] if self._agenda else None
        if self._deadlines and (earliest is None or self._deadlines[0][0] < earliest):
            return self._deadlines[0][0]
        return earliest

    @property
    def awaits(self) -> bool:
        """Whether a command is under way of whose end it will still hear, or which it will give up."""
        return self.insistence.acknowledged and bool(self._open)

    def issue(self, now_ns: int, order: Order) -> int:
        """Send an order; return the id that it has from now on."""
        self._issued += 1
        command_id = self._issued
        self._open[command_id] = _Sent(order)
        text = f"command {command_id} sent: {order.words}"
        self.sink(Event(now_ns, EventKind.COMMAND_SENT, Clock.OPERATOR, Severity.INFO, text, command_id=command_id))
        self._send(now_ns, command_id)
        return command_id

    def hear(self, now_ns: int, message: Ack | Telemetry) -> None:
        """Take what has arrived: it answers, or says that an answer must have been lost."""
        if isinstance(message, Telemetry):
            self._suspect(now_ns, message)
            return
        if message.stage in FINAL_STAGES:
            self._open.pop(message.command_id, None)
        elif message.command_id in self._open:
            sent = self._open[message.command_id]
            if message.issued_ns >= sent.told_ns:  # one that was overtaken is no news
                sent.stage, sent.told_ns = message.stage, message.issued_ns
            sent.answer_by_ns, sent.unanswered = None, 0

    def wake(self, now_ns: int) -> list[int]:
        """Do what is due; return the commands that are given up."""
        while self._agenda and self._agenda[0][0] <= now_ns:
            self.sink(heapq.heappop(self._agenda)[2])
        late = set()
        while self._deadlines and self._deadlines[0][0] <= now_ns:
            deadline = heapq.heappop(self._deadlines)
            if self._holds(deadline):
                late.add(deadline[1])
        return [command_id for command_id in sorted(late) if not self._insist(now_ns, command_id)]

    def state(self) -> Mapping[str, object]:
        """Return what is open, as plain data."""
        return {
            "issued": self._issued,
            "open": [
                [command_id, sent.attempt, sent.stage.value, sent.answer_by_ns]
                for command_id, sent in self._open.items()
            ],
        }

    def _send(self, now_ns: int, command_id: int) -> None:
        sent = self._open[command_id]
        sent.attempt += 1
        sent.unanswered += 1
        attempt, order = sent.attempt, sent.order
        self._tell(now_ns, command_id, Stage.QUEUED)
        fate = self.uplink(now_ns, lambda arrives_ns: order.command(command_id, attempt, now_ns, arrives_ns))
        if fate.departs_ns == NEVER:
            self._tell(now_ns, command_id, Stage.LOST, fate.lost)  # by the ground's own sender, which says so
        else:
            self._later(fate.departs_ns, command_id, Stage.SENT, Clock.OPERATOR)
            if fate.lost:
                self._later(fate.left_ns, command_id, Stage.LOST, Clock.LINK, fate.lost)
        if order.fleeting:
            del self._open[command_id]
        elif self.insistence.acknowledged:
            left_ns = now_ns if fate.departs_ns == NEVER else fate.left_ns
            self._expect(command_id, self.insistence.answer_by(left_ns))

    def _insist(self, now_ns: int, command_id: int) -> bool:
        """Send an unanswered command again; return whether that was worth it."""
        sent = self._open[command_id]
        sent.answer_by_ns = None
        expired = 0 <= sent.order.expires_ns <= now_ns
        if sent.stage in (Stage.QUEUED, Stage.UNKNOWN):
            sent.stage = Stage.UNKNOWN
            self._tell(now_ns, command_id, Stage.UNKNOWN, UNANSWERED)
        if expired or sent.unanswered > self.insistence.retries:
            del self._open[command_id]
            return False
        text = f"command {command_id} sent again: {UNANSWERED} after {sent.attempt}"
        self.sink(Event(now_ns, EventKind.COMMAND_SENT, Clock.OPERATOR, Severity.WARNING, text, command_id=command_id))
        self._send(now_ns, command_id)
        return True

    def _suspect(self, now_ns: int, frame: Telemetry) -> None:
        """Ask again, after a while, for the end of commands of which a robot at rest has not told the end."""
        nothing_to_do = frame.mode in _AT_REST or (frame.mode is Mode.SAFE and frame.target < 0)
        if not self.insistence.acknowledged or not nothing_to_do:
            return
        for command_id, sent in self._open.items():
            kept = sent.order.not_before_ns > frame.issued_ns
            if sent.stage in _UNDER_WAY and sent.answer_by_ns is None and frame.issued_ns > sent.told_ns and not kept:
                self._expect(command_id, now_ns + self.insistence.patience_ns)

    def _expect(self, command_id: int, by_ns: int | None) -> None:
        """Wait for an acknowledgement until then; for ever, where no contact is left."""
        self._open[command_id].answer_by_ns = by_ns
        if by_ns is not None:
            heapq.heappush(self._deadlines, (by_ns, command_id))

    def _holds(self, deadline: tuple[int, int]) -> bool:
        """Tell whether a command is still waited for, and until then."""
        by_ns, command_id = deadline
        return command_id in self._open and self._open[command_id].answer_by_ns == by_ns

    def _tell(self, now_ns: int, command_id: int, stage: Stage, reason: str = "") -> None:
        attempt = self._open[command_id].attempt
        self.sink(CommandStage(now_ns, command_id, stage, reason, Clock.OPERATOR, attempt))

    def _later(self, at_ns: int, command_id: int, stage: Stage, clock: Clock, reason: str = "") -> None:
        attempt = self._open[command_id].attempt
        self._serial += 1
        heapq.heappush(
            self._agenda, (at_ns, self._serial, CommandStage(at_ns, command_id, stage, reason, clock, attempt))
        )
