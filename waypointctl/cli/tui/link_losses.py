"""What the link did in a flight besides delaying, in a line each way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from waypointctl.cli.tui.formatting import at
from waypointctl.display_text import printable
from waypointctl.units import NS_PER_S, seconds

if TYPE_CHECKING:
    from waypointctl.replay.link_summary import LinkDirectionSummary, LinkSummary

# What the log calls a message, in words.
_KINDS: Final = {
    "ack": "acknowledgement",
    "telemetry": "telemetry frame",
    "bodyframe": "state",
    "controlframe": "action",
}


def link_lines(link: LinkSummary) -> list[str]:
    """Return a line for each way on which anything was lost, doubled, dropped or had to wait."""
    ways = (("link up    ", link.up), ("link down  ", link.down))
    return [f"{label}{', '.join(_told(way))}" for label, way in ways if way]


def _told(way: LinkDirectionSummary) -> Iterator[str]:
    missing = [f"{way.lost} lost"] if way.lost else []
    missing += [f"{way.queue_full} dropped, the queue was full"] if way.queue_full else []
    missing += [f"{way.no_contact} dropped, no contact was left"] if way.no_contact else []
    if missing:
        yield f"{'; '.join(missing)} ({', '.join(_several(kind, count) for kind, count in way.not_arrived)})"
    if way.doubled:
        yield f"{way.doubled} doubled"
    if way.waited:
        yield f"{way.waited} waited, at most {_wait(way.longest_wait_ns)}"


def _wait(time_ns: int) -> str:
    """Return a wait; one that is short with two figures, however short."""
    return at(time_ns) if time_ns >= NS_PER_S // 10 else f"{seconds(time_ns) * 1e3:.2g} ms"


def _several(kind: str, count: int) -> str:
    return f"{count} {_KINDS.get(kind, printable(kind))}{'' if count == 1 else 's'}"
