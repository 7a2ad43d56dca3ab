"""Two logs of one flight, record by record: what a comparison of messages cannot see."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import zip_longest

from waypointctl.log.reader import Log
from waypointctl.log.records import RawMessage
from waypointctl.replay.difference import shown
from waypointctl.replay.verdict import Divergence
from waypointctl.replay.witness import Diverged


def compare_records(logged: Log, replayed: Log) -> int:
    """Return how many records two logs have in common: all of them.

    Raises:
        Diverged: at the first attachment, metadata or message of any topic in which they differ.
    """
    _same("metadata", logged.metadata, replayed.metadata)
    _same("attachment", logged.attachments, replayed.attachments)
    count = len(logged.attachments) + 1
    for ours, theirs in zip_longest(logged.raw_messages(), replayed.raw_messages()):
        if ours is None or theirs is None:
            raise Diverged(Divergence(-1, 0, "file", "end", _named(ours), _named(theirs)))
        if (ours[0], ours[1][1:]) != (theirs[0], theirs[1][1:]):
            raise Diverged(Divergence(-1, ours[1].log_time_ns, ours[0], "bytes", _named(ours), _named(theirs)))
        count += 1
    return count


def _same(what: str, logged: Mapping[str, str | bytes], replayed: Mapping[str, str | bytes]) -> None:
    for name in [*replayed, *logged]:
        ours, theirs = logged.get(name), replayed.get(name)
        if ours != theirs:
            raise Diverged(Divergence(-1, 0, what, name, _short(ours), _short(theirs)))


def _short(value: str | bytes | None) -> str:
    if value is None:
        return "nothing"
    return value if isinstance(value, str) else shown(value)


def _named(record: tuple[str, RawMessage] | None) -> str:
    if record is None:
        return "nothing"
    topic, raw = record
    return f"message {raw.sequence} on {topic}, {_short(raw.data)}"
