"""`waypointctl info`: what is in a log."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from waypointctl.log.contents import TopicSummary
    from waypointctl.log.reader import Log


def info(
    log: Annotated[
        Path, typer.Argument(metavar="LOG.mcap", help="A log, or the .part of one whose flight was killed.")
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Show what is in a log: how the flight ended, topics with counts and rates, metadata, attachments.

    Says how long it is and whether it is complete, and checks every checksum on the way. A log that is cut short is
    shown up to where it is whole.
    """
    from waypointctl.log.reader import open_log

    opened = open_log(log, allow_truncated=True)
    if as_json:
        typer.echo(json.dumps(_record(opened)))
    else:
        _show(opened)


def _record(log: Log) -> dict[str, Any]:
    return {
        "log": str(log.path),
        "complete": log.is_complete,
        "size_bytes": log.contents.size_bytes,
        "library": log.contents.library,
        "messages": log.message_count,
        "start_ns": log.start_ns,
        "end_ns": log.end_ns,
        "duration_s": log.duration_s,
        "outcome": _outcome(log),
        "topics": [_topic_record(topic) for topic in log.topics.values()],
        "attachments": [{"name": name, "size_bytes": len(data)} for name, data in log.attachments.items()],
        "metadata": dict(log.metadata),
    }


def _outcome(log: Log) -> str | None:
    """Return what the log says of the flight's end, None if it says nothing."""
    from waypointctl.log.messages import Event, EventKind

    outcome = None
    for message in log.messages(("/event",)):
        if isinstance(message, Event) and message.kind is EventKind.MISSION_ENDED:
            outcome = message.text
    return outcome


def _topic_record(topic: TopicSummary) -> dict[str, Any]:
    return {
        "name": topic.name,
        "schema": topic.schema,
        "count": topic.count,
        "first_ns": topic.first_ns,
        "last_ns": topic.last_ns,
        "rate_hz": topic.rate_hz,
    }


def _show(log: Log) -> None:
    from waypointctl.cli.console import console
    from waypointctl.cli.view.words import printable

    out = console()
    outcome = _outcome(log)
    unsaid, whole = _ending(log)
    out.print(f"{log.path}: {log.duration_s:.3f} s of simulation, {log.message_count} messages", soft_wrap=True)
    out.print(f"outcome: {unsaid if outcome is None else printable(outcome)}", soft_wrap=True)
    out.print(f"{log.contents.size_bytes:,} bytes, written by {log.contents.library}, {whole}")
    out.print()
    out.print(_topic_table(log))
    out.print(_pair_table("attachment", "bytes", {name: f"{len(it):,}" for name, it in log.attachments.items()}))
    out.print(_pair_table("metadata", "", dict(log.metadata)))


def _ending(log: Log) -> tuple[str, str]:
    """Return what to say of an outcome that the log does not tell, and of the file's end."""
    from waypointctl.log.lock import lock

    if log.is_complete:
        return "not said: the log has no such event", "complete"
    with log.path.open("rb") as stream:
        if not lock(stream):
            return "not said yet: the flight is under way", "being written"
    return "not said: the flight was killed", "cut short: its writer was killed, or it was not copied to its end"


def _topic_table(log: Log) -> Table:
    from waypointctl.units import seconds

    table = _table("topic", "schema")
    for column in ("messages", "rate [Hz]", "first [s]", "last [s]"):
        table.add_column(column, justify="right")
    for topic in log.topics.values():
        rate = "" if topic.rate_hz is None else f"{topic.rate_hz:.1f}"
        times = ("" if time is None else f"{seconds(time):.3f}" for time in (topic.first_ns, topic.last_ns))
        table.add_row(topic.name, topic.schema, str(topic.count), rate, *times)
    return table


def _pair_table(left: str, right: str, rows: dict[str, str]) -> Table:
    table = _table(left)
    table.add_column(right, overflow="fold")
    for row in rows.items():
        table.add_row(*row)
    return table


def _table(*columns: str) -> Table:
    from rich.box import SIMPLE
    from rich.table import Table

    table = Table(box=SIMPLE, pad_edge=False)
    for column in columns:
        table.add_column(column, no_wrap=True)
    return table
