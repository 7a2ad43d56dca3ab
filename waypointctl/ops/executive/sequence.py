"""The order in which the ground issued its commands, where the link did not keep it.

Ids count up in the order of issue. A link may bring an older command after a newer one: because its jitter keeps no
order, or because the older one was lost and sent again. What the robot does in the end is what it would do had they
come in order:

- An older command that a newer one had done with is dropped (SKIPPED, "overtaken by command 7"): `_DONE_WITH_BY` says
  which kind does that to which. The newer one's `do` was obeyed already; the older one must not undo it.
- A newer command that changes how an older one is carried out (hold, release, tolerance, time-out, cancel) is
  remembered for those that are still to come.

A command counts from when it is to start: one with a `not_before` to come is not overtaken by what starts before that,
but by an abort, which ends what waits too.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from waypointctl.log.messages import Command, CommandKind

_FOR_EVER_NS: Final = 2**63 - 1
_ALL: Final = 2**31

# They put an end to all that was under way.
ENDING: Final = frozenset(
    {CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, CommandKind.RETURN_HOME, CommandKind.ABORT},
)
_DONE_WITH_BY: Final = {kind: ENDING for kind in CommandKind if kind is not CommandKind.CANCEL} | {
    CommandKind.CANCEL: frozenset[CommandKind](),  # it names what it is about
    CommandKind.HOLD: ENDING | {CommandKind.RESUME},
    CommandKind.RESUME: ENDING | {CommandKind.HOLD},
    CommandKind.SET_TOLERANCE: ENDING | {CommandKind.SET_TOLERANCE},
    CommandKind.SET_TIMEOUT: ENDING | {CommandKind.SET_TIMEOUT},
}


@dataclass(slots=True)
class Sequence:
    """What has been obeyed, as far as it matters for older commands that are still to come.

    Attributes:
        kept: every command has come in its turn so far: ids 1, 2, 3, ... Then all of this follows from them.
    """

    kept: bool = True
    _newest: int = 0
    # By kind: (id, until when an older command had to start to be done with [ns]). Of two of which one is newer and
    # later as well, that one says it all.
    _obeyed: dict[CommandKind, list[tuple[int, int]]] = field(default_factory=dict)
    _released: list[tuple[int, int]] = field(default_factory=list)  # (id, waypoints), the same way
    _values: dict[CommandKind, tuple[int, float]] = field(default_factory=dict)  # (id, value) of the newest
    _cancelled: dict[int, int] = field(default_factory=dict)  # what has not arrived yet: by which command

    def receive(self, command_id: int) -> None:
        """Take note that a command has arrived for the first time."""
        self.kept = self.kept and command_id == self._newest + 1
        self._newest = max(self._newest, command_id)

    def obey(self, command: Command, starts_ns: int) -> None:
        """Take note of what is obeyed now, and of when it was to start [ns]."""
        kind = command.kind
        until_ns = _FOR_EVER_NS if kind is CommandKind.ABORT else starts_ns
        _add(self._obeyed.setdefault(kind, []), command.id, until_ns)
        if kind is CommandKind.RELEASE:
            _add(self._released, command.id, _ALL if command.released < 0 else command.released)
        elif kind in (CommandKind.SET_TOLERANCE, CommandKind.SET_TIMEOUT):
            self._values[kind] = command.id, command.value  # an older one is dropped: this is the newest

    def overtaking(self, command: Command) -> int | None:
        """Return the newest command that an older one comes too late for; None if it does not."""
        return self._newest_of(_DONE_WITH_BY[command.kind], command)

    def held_by(self, command: Command) -> int | None:
        """Return the hold that a command has to stand still for although it comes after it; None if there is none."""
        held = self._newest_of({CommandKind.HOLD}, command)
        if held is None:
            return None
        resumed = self._newest_of({CommandKind.RESUME}, command)
        return held if resumed is None or resumed < held else None

    def released_for(self, command: Command) -> int:
        """Return how many waypoints newer commands have released, counted from the plan's first; -1 for all."""
        count = max((count for command_id, count in self._released if command_id > command.id), default=0)
        return -1 if count == _ALL else count

    def value_for(self, command: Command, kind: CommandKind) -> float | None:
        """Return the tolerance [m] or time-out [s] that a newer command has set; None if none has."""
        setting = self._values.get(kind)
        return setting[1] if setting is not None and setting[0] > command.id else None

    def cancel(self, target_id: int, by_id: int) -> None:
        """Remember that a command which has not arrived yet is not wanted any more."""
        self._cancelled.setdefault(target_id, by_id)

    def take_cancel(self, command_id: int) -> int | None:
        """Return what cancelled a command that arrives now, before it did; None if nothing did."""
        return self._cancelled.pop(command_id, None)

    def state(self) -> dict[str, object]:
        """Return all of it as plain data."""
        return {
            "obeyed": {kind.value: [list(mark) for mark in marks] for kind, marks in self._obeyed.items()},
            "released": [list(mark) for mark in self._released],
            "values": {kind.value: list(setting) for kind, setting in self._values.items()},
            "cancelled": [list(pair) for pair in self._cancelled.items()],
        }

    def _newest_of(self, kinds: frozenset[CommandKind] | set[CommandKind], command: Command) -> int | None:
        """Return the newest command of some kinds that is newer than this one, and was not to start before it."""
        newer = [
            command_id
            for kind in kinds
            for command_id, until_ns in self._obeyed.get(kind, ())
            if command_id > command.id and command.not_before_ns <= until_ns
        ]
        return max(newer, default=None)


def _add(marks: list[tuple[int, int]], command_id: int, much: int) -> None:
    """Add a mark, unless one is newer and no less; it takes the place of those that are older and no more."""
    if any(other_id >= command_id and other >= much for other_id, other in marks):
        return
    marks[:] = [mark for mark in marks if mark[0] > command_id or mark[1] > much]
    marks.append((command_id, much))
