"""The life cycle of a command on the ground: sent, sent again while unacknowledged, and known to have ended.

    QUEUED -> SENT -> (the link: LOST, or it arrives) ... any acknowledgement ... a final one
      ^                  |
      +--- UNKNOWN <-----+  no acknowledgement by when there has to be one: it is sent again under the same id

A frame of telemetry that names a command counts as an acknowledgement: the command is not sent again. Where the frame
reports its end, the operator waits a little longer for the acknowledgement, and then takes the frame's report. A
command that was sent as often as allowed stays unknown until a later report of it arrives.

That a command was lost is logged although the operator cannot know it.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

from waypointctl.flight.command_life import ONBOARD, StageReport
from waypointctl.flight.link.direction import NEVER, Delivery
from waypointctl.flight.operator.requests import CommandRequest, EventQueue
from waypointctl.flight.operator.timing import RetryPolicy
from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Clock,
    CommandStage,
    Event,
    EventKind,
    Mode,
    Severity,
    Stage,
    Telemetry,
)

UNANSWERED: Final = "no acknowledgement"
_JUST_SENT: Final = StageReport(Stage.QUEUED, "", -1)  # nothing has been reported
_AT_REST: Final = frozenset({Mode.IDLE, Mode.DONE, Mode.FAILED, Mode.FALLEN})  # no command is under way

# Sends a message at a time [ns]; the callback gets the time of arrival and returns what arrives.
Uplink: TypeAlias = Callable[[int, Callable[[int], Any]], Delivery]


@dataclass(slots=True)
class _Sent:
    request: CommandRequest
    attempt: int = 0
    known: StageReport = _JUST_SENT  # the newest that counts, with the robot's time
    end: Ack | None = None  # as telemetry has reported it, while its acknowledgement may still come
    answer_by_ns: int | None = None


@dataclass(slots=True)
class Dispatcher:
    """Gives orders their ids, sends them, and sends them again."""

    uplink: Uplink  # takes a command on its way
    retry_policy: RetryPolicy  # when commands are sent again
    # Takes each stage of a command on the ground and on the link, and the events
    sink: Callable[[CommandStage | Event], None]
    _issued: int = 0
    _open: dict[int, _Sent] = field(default_factory=dict)  # by id: no final stage is known
    _unanswered: dict[int, _Sent] = field(default_factory=dict)  # not sent again; a late report reopens them
    _upcoming: EventQueue[CommandStage] = field(default_factory=EventQueue)  # future stages
    _deadlines: list[tuple[int, int]] = field(default_factory=list)  # a heap: (answer by, id), some no longer so

    @property
    def wake_ns(self) -> int | None:
        """When there is something to do next [ns]; None for never."""
        while self._deadlines and not self._is_current(self._deadlines[0]):
            heapq.heappop(self._deadlines)
        earliest = self._upcoming.next_ns
        if self._deadlines and (earliest is None or self._deadlines[0][0] < earliest):
            return self._deadlines[0][0]
        return earliest

    @property
    def awaits(self) -> bool:
        """Whether a command is open: its end will be reported, or it will time out."""
        return self.retry_policy.acknowledged and bool(self._open)

    @property
    def unanswered(self) -> tuple[int, ...]:
        """The commands that were sent as often as allowed, and were never reported."""
        return tuple(self._unanswered)

    def missing(self, command_id: int) -> str:
        """Return which report of a command is missing; empty where its end is known."""
        sent = self._open.get(command_id) or self._unanswered.get(command_id)
        if sent is None or not self.retry_policy.acknowledged:
            return ""
        command = f"command {command_id} ({sent.request.words})"
        if sent.known.stage not in ONBOARD:
            return f"{UNANSWERED} of {command}"
        return f"no final stage received for {command}; its last known stage is {sent.known.stage}"

    def issue(self, now_ns: int, request: CommandRequest) -> int:
        """Send a request; return the id that it has from now on."""
        self._issued += 1
        command_id = self._issued
        self._open[command_id] = _Sent(request)
        self._announce(now_ns, EventKind.COMMAND_SENT, command_id, f"sent: {request.words}")
        self._send(now_ns, command_id)
        return command_id

    def on_message(self, now_ns: int, message: Ack | Telemetry) -> None:
        """Process what has arrived: an acknowledgement, or a frame with the stages of commands."""
        if isinstance(message, Ack):
            self._update(now_ns, message, acknowledged=True)
            return
        for it in message.commands:
            report = Ack(it.command_id, it.stage, it.reason, message.issued_ns, now_ns)
            self._update(now_ns, report, acknowledged=False)
        self._query_silent(now_ns, message)

    def wake(self, now_ns: int) -> list[Ack]:
        """Do what is due; return the ends taken from telemetry, in the form of acknowledgements."""
        for stage in self._upcoming.due(now_ns):
            self.sink(stage)
        late = set()
        while self._deadlines and self._deadlines[0][0] <= now_ns:
            deadline = heapq.heappop(self._deadlines)
            if self._is_current(deadline):
                late.add(deadline[1])
        known = [self._conclude(now_ns, each) for each in sorted(late) if self._open[each].end is not None]
        for command_id in sorted(late & self._open.keys()):
            self._retry(now_ns, command_id)
        return known

    def state(self) -> Mapping[str, object]:
        """Return what is open, as plain data."""
        return {
            "issued": self._issued,
            "open": [
                [command_id, sent.attempt, sent.known.stage.value, sent.answer_by_ns]
                for command_id, sent in self._open.items()
            ],
            "unanswered": list(self._unanswered),
        }

    def _update(self, now_ns: int, report: Ack, *, acknowledged: bool) -> None:
        """Process a report of a command, from an acknowledgement or a frame of telemetry."""
        command_id = report.command_id
        if command_id in self._unanswered:
            self._open[command_id] = self._unanswered.pop(command_id)
        sent = self._open.get(command_id)
        if sent is None:
            return
        if report.stage in FINAL_STAGES and acknowledged:
            del self._open[command_id]
        elif report.stage in FINAL_STAGES:
            if sent.end is None:
                sent.end = report
                self._expect(command_id, now_ns + self.retry_policy.patience_ns)
        elif sent.end is None:
            reported = StageReport(report.stage, report.reason, report.issued_ns)
            if reported.counts_after(sent.known):
                sent.known = reported
            sent.answer_by_ns = None

    def _conclude(self, now_ns: int, command_id: int) -> Ack:
        """Take a command's end from telemetry: its acknowledgement has not come."""
        end = self._open.pop(command_id).end
        assert end is not None
        text = f"is known from telemetry to be {end.stage}{f' ({end.reason})' if end.reason else ''}"
        self._announce(now_ns, EventKind.COMMAND_KNOWN, command_id, text)
        return end

    def _send(self, now_ns: int, command_id: int) -> None:
        sent = self._open[command_id]
        sent.attempt += 1
        attempt, request = sent.attempt, sent.request
        self._log_stage(now_ns, command_id, Stage.QUEUED)
        delivery = self.uplink(now_ns, lambda arrives_ns: request.command(command_id, attempt, now_ns, arrives_ns))
        if delivery.departs_ns == NEVER:
            self._log_stage(now_ns, command_id, Stage.LOST, delivery.lost)  # the ground's own sender reports it
        else:
            self._log_later(delivery.departs_ns, command_id, Stage.SENT, Clock.OPERATOR)
            if delivery.lost:
                self._log_later(delivery.left_ns, command_id, Stage.LOST, Clock.LINK, delivery.lost)
        if request.transient:
            del self._open[command_id]
        elif self.retry_policy.acknowledged:
            left_ns = now_ns if delivery.departs_ns == NEVER else delivery.left_ns
            self._expect(command_id, self.retry_policy.answer_by(left_ns))

    def _retry(self, now_ns: int, command_id: int) -> None:
        """Send a command again whose acknowledgement or end is missing, as often as allowed."""
        sent = self._open[command_id]
        sent.answer_by_ns = None
        is_known = sent.known.stage in ONBOARD
        if not is_known:
            sent.known = StageReport(Stage.UNKNOWN, UNANSWERED, sent.known.time_ns)
            self._log_stage(now_ns, command_id, Stage.UNKNOWN, UNANSWERED)
        expired = 0 <= sent.request.expires_ns <= now_ns
        if expired or sent.attempt > self.retry_policy.retries:
            if not is_known:
                self._unanswered[command_id] = self._open.pop(command_id)
            return
        why = f"transmission {sent.attempt} was not acknowledged"
        if is_known:
            why = f"no final stage received; its last known stage is {sent.known.stage}"
        text = f"sent again (transmission {sent.attempt + 1}): {why}"
        self._announce(now_ns, EventKind.COMMAND_SENT, command_id, text, Severity.WARNING)
        self._send(now_ns, command_id)

    def _query_silent(self, now_ns: int, frame: Telemetry) -> None:
        """Ask again, after a while, for the end of commands whose end a robot at rest has not reported."""
        nothing_to_do = frame.mode in _AT_REST or (frame.mode is Mode.SAFE and frame.target < 0)
        if not self.retry_policy.acknowledged or not nothing_to_do:
            return
        reported = {each.command_id for each in frame.commands}
        for command_id, sent in self._open.items():
            kept = sent.request.not_before_ns > frame.issued_ns
            silent = sent.known.stage in ONBOARD and sent.answer_by_ns is None and frame.issued_ns > sent.known.time_ns
            if silent and not kept and command_id not in reported and sent.attempt <= self.retry_policy.retries:
                self._expect(command_id, now_ns + self.retry_policy.patience_ns)

    def _expect(self, command_id: int, by_ns: int | None) -> None:
        """Wait for an acknowledgement until then; for ever, where no contact is left."""
        self._open[command_id].answer_by_ns = by_ns
        if by_ns is not None:
            heapq.heappush(self._deadlines, (by_ns, command_id))

    def _is_current(self, deadline: tuple[int, int]) -> bool:
        """Return whether a command is still waited for, and until then."""
        by_ns, command_id = deadline
        return command_id in self._open and self._open[command_id].answer_by_ns == by_ns

    def _announce(
        self, now_ns: int, kind: EventKind, command_id: int, text: str, severity: Severity = Severity.INFO
    ) -> None:
        text = f"command {command_id} {text}"
        self.sink(Event(now_ns, kind, Clock.OPERATOR, severity, text, command_id=command_id))

    def _log_stage(self, now_ns: int, command_id: int, stage: Stage, reason: str = "") -> None:
        attempt = self._open[command_id].attempt
        self.sink(CommandStage(now_ns, command_id, stage, reason, Clock.OPERATOR, attempt))

    def _log_later(self, at_ns: int, command_id: int, stage: Stage, clock: Clock, reason: str = "") -> None:
        attempt = self._open[command_id].attempt
        self._upcoming.add(at_ns, CommandStage(at_ns, command_id, stage, reason, clock, attempt))
