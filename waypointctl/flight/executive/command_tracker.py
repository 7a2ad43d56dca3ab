"""Every command that has arrived on board, its stage, and when those that wait are due or expire."""

from __future__ import annotations

import heapq
from bisect import insort
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from itertools import islice
from typing import Final

from waypointctl.flight.command_life import NOT_STARTED, may_follow
from waypointctl.log.messages import FINAL_STAGES, Clock, Command, CommandStage, CommandStatus, Stage

_IN_A_FRAME: Final = 3  # commands whose stage a frame of telemetry carries
_REMEMBERED: Final = 256  # of the commands that have ended, in a checkpoint: its size is not to grow with the flight


@dataclass(slots=True)
class Record:
    """The state of a command on board."""

    stage: Stage  # the last it has come to
    reason: str  # of that stage
    attempt: int  # which sending of it was executed
    expires_ns: int  # after which it is not to be started or gone on with; -1 for never


@dataclass(slots=True)
class CommandTracker:
    """Every command that has arrived, by its id."""

    report: Callable[[CommandStage], None]  # takes each stage at its moment
    remind: Callable[[CommandStage], None]  # takes the stage that a command is in when it arrives once more
    records: dict[int, Record] = field(default_factory=dict)  # of each id
    # Accepted, and not to be started yet; those that start first are first
    pending: list[Command] = field(default_factory=list)
    _open: dict[int, None] = field(default_factory=dict)  # ids without a final stage, as they arrived
    _expiries: list[tuple[int, int, int]] = field(default_factory=list)  # a heap: (after which [ns], arrival, id)
    _pending_ids: set[int] = field(default_factory=set)
    _known_to: int = 0  # every id from 1 to this has arrived
    _ended: deque[int] = field(default_factory=lambda: deque(maxlen=_IN_A_FRAME))  # ids that ended last
    _statuses: tuple[CommandStatus, ...] | None = None  # as `statuses` has them; None where they have changed

    def knows(self, command_id: int) -> bool:
        """Return whether a command has arrived."""
        return command_id in self.records

    def knows_all_before(self, command_id: int) -> bool:
        """Return whether every command with a smaller id has arrived: the ground counts them from 1."""
        return command_id <= self._known_to + 1

    def receive(self, now_ns: int, command: Command) -> None:
        """Enter a command that arrives for the first time."""
        self.records[command.id] = Record(Stage.RECEIVED, "", command.attempt, command.expires_ns)
        self._open[command.id] = None
        if command.expires_ns >= 0:
            heapq.heappush(self._expiries, (command.expires_ns, len(self.records), command.id))
        while self._known_to + 1 in self.records:
            self._known_to += 1
        self._statuses = None
        self.report(self._stage(now_ns, command.id))

    def repeat(self, now_ns: int, command: Command) -> None:
        """Acknowledge once more the stage of a command that has arrived again."""
        record = self.records[command.id]
        self.remind(CommandStage(now_ns, command.id, record.stage, record.reason, Clock.ROBOT, command.attempt))

    def advance(self, now_ns: int, command_id: int, stage: Stage, reason: str = "") -> None:
        """Take a command to a stage.

        Raises:
            RuntimeError: that stage cannot follow the one the command is in. That is a bug.
        """
        record = self.records[command_id]
        if not may_follow(stage, record.stage):
            raise RuntimeError(f"command {command_id} cannot be {stage} after it was {record.stage}")
        record.stage, record.reason = stage, reason
        self._statuses = None
        if stage in FINAL_STAGES:
            del self._open[command_id]
            if command_id in self._pending_ids:
                self._pending_ids.remove(command_id)
                self.pending = [command for command in self.pending if command.id != command_id]
            self._ended.append(command_id)
        self.report(self._stage(now_ns, command_id))

    def postpone(self, command: Command) -> None:
        """Keep an accepted command until it may start."""
        self._pending_ids.add(command.id)
        insort(self.pending, command, key=lambda waiting: (waiting.not_before_ns, waiting.id))  # the older one first

    def take_due(self, now_ns: int) -> Command | None:
        """Take out the first command that may start by now."""
        if self.pending and self.pending[0].not_before_ns <= now_ns:
            command = self.pending.pop(0)
            self._pending_ids.remove(command.id)
            return command
        return None

    def is_open(self, command_id: int) -> bool:
        """Return whether a command has arrived and has not ended."""
        return command_id in self._open

    def has_started(self, command_id: int) -> bool:
        """Return whether a command is under way, or has been."""
        return self.records[command_id].stage not in NOT_STARTED

    @property
    def open_ids(self) -> list[int]:
        """The commands that have not ended, in the order of their arrival."""
        return list(self._open)

    @property
    def statuses(self) -> tuple[CommandStatus, ...]:
        """Command statuses in a frame of telemetry: the newest open commands, and those that ended last."""
        if self._statuses is None:
            reported = list(islice(reversed(self._open), _IN_A_FRAME - 1))
            reported += list(islice(reversed(self._ended), _IN_A_FRAME - len(reported)))
            of = self.records
            self._statuses = tuple(CommandStatus(i, of[i].stage, of[i].reason) for i in sorted(reported))
        return self._statuses

    def expired(self, now_ns: int) -> list[int]:
        """Record that the time of some open commands is over, and return them as they arrived: each once."""
        over = []
        while self._expiries and self._expiries[0][0] < now_ns:
            _, arrival, command_id = heapq.heappop(self._expiries)
            if command_id in self._open:
                over.append((arrival, command_id))
        return [command_id for _, command_id in sorted(over)]

    @property
    def next_expiry_ns(self) -> int | None:
        """When the time of the next open command is over; None if none has an end."""
        while self._expiries and self._expiries[0][2] not in self._open:
            heapq.heappop(self._expiries)
        return self._expiries[0][0] if self._expiries else None

    def state(self) -> dict[str, object]:
        """Return it as plain data; of commands that ended long ago, which may be thousands, only how many they are."""
        newest = list(islice(reversed(self.records), _REMEMBERED))[::-1]
        listed = dict.fromkeys([*sorted(self._open.keys() - set(newest)), *newest])
        records: dict[str, object] = {str(command_id): asdict(self.records[command_id]) for command_id in listed}
        older = {"older": len(self.records) - len(records)} if len(records) < len(self.records) else {}
        pending = [{**asdict(command), "waypoints": [asdict(w) for w in command.waypoints]} for command in self.pending]
        return {"records": records, "pending": pending, **older}

    def _stage(self, now_ns: int, command_id: int) -> CommandStage:
        record = self.records[command_id]
        return CommandStage(now_ns, command_id, record.stage, record.reason, Clock.ROBOT, record.attempt)
