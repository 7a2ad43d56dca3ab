"""The order in which the ground issued its commands, where the link did not keep it.

Ids count up in the order of issue. A command starts when it arrives, or at its `not_before` if that is later. Had all
arrived as they were issued, the robot would execute them by their starts, and of two with one start the older first. A
link may bring an older command after a newer one: because its jitter keeps no order, or because the older one was lost
and sent again. A newer command that was executed *follows* such an older one, unless the older one's `not_before` is
later than the newer one's start. An abort follows every older command, for it ends those too that wait. Then

- an older command is dropped if a newer one that follows it made it obsolete (SKIPPED, "overtaken by command 7"):
  `_OBSOLETED_BY` lists which kinds do that. The newer command was executed already; the older one must not undo it. An
  abort that is dropped still makes all older commands obsolete.
- a newer command that changes how one that it follows is carried out (hold, release, tolerance, time-out, cancel) is
  stored for those that are still to arrive.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from waypointctl.log.messages import TELEOPERATION, Command, CommandKind

_FOR_EVER_NS: Final = 2**63 - 1
_ALL: Final = 2**31

# They end everything that is under way.
ENDING: Final = frozenset(
    {CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, CommandKind.RETURN_HOME, CommandKind.ABORT},
)
_OBSOLETED_BY: Final = {kind: ENDING for kind in CommandKind if kind is not CommandKind.CANCEL} | {
    CommandKind.CANCEL: frozenset[CommandKind](),  # it names its target
    CommandKind.HOLD: ENDING | {CommandKind.RESUME},
    CommandKind.RESUME: ENDING | {CommandKind.HOLD},
    CommandKind.SET_TOLERANCE: ENDING | {CommandKind.SET_TOLERANCE},
    CommandKind.SET_TIMEOUT: ENDING | {CommandKind.SET_TIMEOUT},
}


@dataclass(frozen=True, slots=True)
class _Mark:
    """What is stored about a command that was executed."""

    start_ns: int  # when it was to start; an abort's is later than any
    command_id: int  # of it
    released: int  # how many waypoints it released, counted from the plan's first; 0 for other kinds
    value: float  # the tolerance [m] or the time-out [s] that it set

    def follows(self, command: Command) -> bool:
        """Return whether it is newer than another, and was not to start before it."""
        return self.command_id > command.id and self.start_ns >= command.not_before_ns

    def covers(self, other: _Mark) -> bool:
        """Return whether the other mark is redundant: this one follows every command that the other follows."""
        newer = self.command_id >= other.command_id and self.start_ns >= other.start_ns
        return newer and self.released >= other.released


@dataclass(slots=True)
class CommandOrdering:
    """The executed commands, as far as they affect older commands that are still to arrive."""

    kept: bool = True  # every command has come in its turn so far: ids 1, 2, 3, ... Then all of this follows from them
    _newest: int = 0
    _executed: dict[CommandKind, list[_Mark]] = field(default_factory=dict)
    # What has not arrived yet: by which command, and when that one was to start [ns].
    _cancelled: dict[int, tuple[int, int]] = field(default_factory=dict)

    def receive(self, command_id: int) -> None:
        """Record that a command has arrived for the first time."""
        self.kept = self.kept and command_id == self._newest + 1
        self._newest = max(self._newest, command_id)

    def record(self, command: Command, start_ns: int) -> None:
        """Record a command that is executed now, and when it was to start [ns]."""
        if command.target_id == TELEOPERATION:
            return  # it holds no other command
        kind, released = command.kind, 0
        if kind is CommandKind.ABORT:
            start_ns = _FOR_EVER_NS
        elif kind is CommandKind.RELEASE:
            released = _ALL if command.released < 0 else command.released
        new, marks = _Mark(start_ns, command.id, released, command.value), self._executed.setdefault(kind, [])
        if not any(mark.covers(new) for mark in marks):
            marks[:] = [*(mark for mark in marks if not new.covers(mark)), new]

    def overtaking(self, command: Command) -> int | None:
        """Return the newest command that makes an older one obsolete; None if there is none."""
        marks = self._following(command, _OBSOLETED_BY[command.kind])
        return max((mark.command_id for mark in marks), default=None)

    def held_by(self, command: Command) -> int | None:
        """Return the newer hold that applies to a command although it was executed before; None if there is none."""
        last = self._last(command, CommandKind.HOLD, CommandKind.RESUME)
        return None if last is None or last not in self._executed.get(CommandKind.HOLD, ()) else last.command_id

    def released_for(self, command: Command) -> int:
        """Return how many waypoints newer commands have released, counted from the plan's first; -1 for all."""
        count = max((mark.released for mark in self._following(command, {CommandKind.RELEASE})), default=0)
        return -1 if count == _ALL else count

    def value_for(self, command: Command, kind: CommandKind) -> float | None:
        """Return the tolerance [m] or time-out [s] that a newer command has set; None if none has."""
        last = self._last(command, kind)
        return None if last is None else last.value

    def cancel(self, target_id: int, by_id: int, start_ns: int) -> None:
        """Store that a command which has not arrived yet is cancelled from a time on [ns]."""
        self._cancelled.setdefault(target_id, (by_id, start_ns))

    def take_cancel(self, command: Command) -> tuple[int, bool] | None:
        """Return what cancelled a command that arrives now, before it did; None if nothing did.

        With it comes whether the command would have been begun by then, had it come before.
        """
        by_id, start_ns = self._cancelled.pop(command.id, (None, 0))
        return None if by_id is None else (by_id, command.not_before_ns <= start_ns)

    def state(self) -> dict[str, object]:
        """Return all of it as plain data."""
        settings = (CommandKind.SET_TOLERANCE, CommandKind.SET_TIMEOUT)
        return {
            "executed": {
                kind.value: [[mark.command_id, mark.start_ns] for mark in marks]
                for kind, marks in self._executed.items()
            },
            "released": [[mark.command_id, mark.released] for mark in self._executed.get(CommandKind.RELEASE, ())],
            "values": {
                kind.value: [[mark.command_id, mark.value] for mark in self._executed[kind]]
                for kind in settings
                if kind in self._executed
            },
            "cancelled": [[target_id, *cancel] for target_id, cancel in self._cancelled.items()],
        }

    def _following(self, command: Command, kinds: Iterable[CommandKind]) -> list[_Mark]:
        """Return what was executed of some kinds that follows a command."""
        return [mark for kind in kinds for mark in self._executed.get(kind, ()) if mark.follows(command)]

    def _last(self, command: Command, *kinds: CommandKind) -> _Mark | None:
        """Return the last of what was executed of some kinds that follows a command."""
        return max(self._following(command, kinds), key=lambda mark: (mark.start_ns, mark.command_id), default=None)
