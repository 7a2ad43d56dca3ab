"""A command as the summary of a flight has it, and the fold of messages that makes it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from waypointctl.flight.command_life import StageReport, names
from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Clock,
    Command,
    CommandKind,
    CommandStage,
    CommandStatus,
    Event,
    EventKind,
    Severity,
    Stage,
    Telemetry,
)


@dataclass(frozen=True, slots=True)
class CommandSummary:
    """A command, from its first sending to the last report of it that the operator received."""

    id: int  # as it was sent
    kind: CommandKind | None = None  # known from its arrival on board; None before
    description: str = ""  # its kind and its waypoints, for people
    issued_ns: int = 0  # on the operator's clock, the first time
    received_ns: int | None = None  # on the robot's clock, the first time; None before it has arrived
    uplink_ns: int | None = None  # delay of the sending that arrived first
    onboard: Stage | None = None  # the last stage it came to on board, None before it arrived
    ended_ns: int | None = None  # when it ended on board, on the robot's clock
    attempts: int = 0  # how often it was sent
    losses: int = 0  # how often the link lost it, which the operator does not know
    acks: tuple[Ack, ...] = ()  # those that have arrived at the operator, in order
    # its final stage as telemetry first reported it, and when that arrived [ns]
    telemetry_end: tuple[Stage, int] | None = None
    # of each sending that arrived: when it was sent, and when it arrived [ns]
    arrivals: tuple[tuple[int, int], ...] = ()
    # the newest stage that the operator knows, from whatever source; None before the first
    report: StageReport | None = None

    @property
    def downlink_ns(self) -> int | None:
        """How old the first acknowledgement was when the operator received it."""
        return self.acks[0].received_ns - self.acks[0].issued_ns if self.acks else None

    @property
    def acknowledged_ns(self) -> int | None:
        """When the first acknowledgement arrived, on the operator's clock."""
        return self.acks[0].received_ns if self.acks else None

    @property
    def round_trip_ns(self) -> int | None:
        """From the sending that its first acknowledgement answers to that acknowledgement, on the operator's clock.

        That is the newest sending that had arrived when the robot acknowledged; the first one where none is known to.
        """
        if not self.acks:
            return None
        ack = self.acks[0]
        sent_ns = (sent_ns for sent_ns, arrived_ns in self.arrivals if arrived_ns <= ack.issued_ns)
        return ack.received_ns - max(sent_ns, default=self.issued_ns)

    @property
    def known_stage(self) -> Stage:
        """The last stage that was acknowledged, or the end that telemetry reported; SENT before either."""
        acknowledged = self.acks[-1].stage if self.acks else Stage.SENT
        if acknowledged in FINAL_STAGES or self.telemetry_end is None:
            return acknowledged
        return self.telemetry_end[0]

    @property
    def end_known_ns(self) -> int | None:
        """When the operator learned that it had ended, on the operator's clock."""
        acked_ns = next((ack.received_ns for ack in self.acks if ack.stage in FINAL_STAGES), None)
        return self.telemetry_end[1] if acked_ns is None and self.telemetry_end is not None else acked_ns


class CommandsBuilder:
    """Makes the commands of a flight out of its messages."""

    def __init__(self) -> None:
        """Begin without any."""
        self._commands: dict[int, CommandSummary] = {}
        self._acknowledged = -1  # the newest command that was acknowledged

    @property
    def commands(self) -> tuple[CommandSummary, ...]:
        """The commands so far, by id."""
        return tuple(command for _, command in sorted(self._commands.items()))

    def newest(self, most: int) -> tuple[CommandSummary, ...]:
        """Return the last `most` commands that were issued, by id."""
        return tuple(self._commands[command_id] for command_id in sorted(islice(reversed(self._commands), most)))

    @property
    def round_trip_ns(self) -> int | None:
        """The round trip of the newest command that was acknowledged [ns]; None without one."""
        command = self._commands.get(self._acknowledged)
        return None if command is None else command.round_trip_ns

    def on_status(self, it: CommandStatus, frame: Telemetry) -> None:
        """Take what a frame of telemetry reports of a command."""
        command = self._command(it.command_id)
        if it.stage in FINAL_STAGES and command.telemetry_end is None:
            command = self._update(command, telemetry_end=(it.stage, frame.received_ns))
        known = command.report
        report = StageReport(it.stage, it.reason, frame.issued_ns)
        if report.counts_after(known) and (known is None or known.stage != report.stage):
            self._update(command, report=report)

    def on_ack(self, ack: Ack) -> None:
        """Take an acknowledgement that has arrived."""
        command = self._command(ack.command_id)
        report = StageReport(ack.stage, ack.reason, ack.issued_ns)
        known = report if report.counts_after(command.report) else command.report
        self._update(command, acks=(*command.acks, ack), report=known)
        self._acknowledged = max(self._acknowledged, ack.command_id)

    def on_command(self, command: Command) -> None:
        """Take a command that has arrived on board."""
        entry = self._command(command.id)
        entry = self._update(entry, arrivals=(*entry.arrivals, (command.issued_ns, command.received_ns)))
        if entry.received_ns is None:  # what arrives once more is only acknowledged once more
            self._update(
                entry,
                kind=command.kind,
                description=f"{command.kind} {names(command.waypoints)}".rstrip(),
                issued_ns=entry.issued_ns if entry.attempts else command.issued_ns,
                received_ns=command.received_ns,
                uplink_ns=command.received_ns - command.issued_ns,
            )

    def on_stage(self, it: CommandStage) -> CommandSummary:
        """Take a stage of a command; return the command."""
        entry = self._command(it.command_id)
        entry = self._update(
            entry,
            attempts=max(entry.attempts, it.attempt),
            issued_ns=it.time_ns if it.stage is Stage.QUEUED and it.attempt == 1 else entry.issued_ns,
            losses=entry.losses + (it.stage is Stage.LOST),
        )
        if it.clock is Clock.OPERATOR:
            return self._update(entry, report=StageReport(it.stage, it.reason, it.time_ns))
        if it.clock is Clock.ROBOT and entry.onboard not in FINAL_STAGES:
            return self._update(entry, onboard=it.stage, ended_ns=it.time_ns if it.stage in FINAL_STAGES else None)
        return entry

    def on_event(self, event: Event) -> None:
        """Take an event: a command was sent."""
        if event.kind is EventKind.COMMAND_SENT and event.severity is Severity.INFO:
            self._update(self._command(event.command_id), description=event.text.partition(": ")[2])

    def _command(self, command_id: int) -> CommandSummary:
        return self._commands.setdefault(command_id, CommandSummary(command_id))

    def _update(self, command: CommandSummary, **changes: Any) -> CommandSummary:
        command = self._commands[command.id] = replace(command, **changes)
        return command
