"""`waypointctl info`: what is in a log."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from waypointctl.display_text import printable
from waypointctl.evaluation.grid import Column, Grid

if TYPE_CHECKING:
    from waypointctl.log.reader import LogReader

_TOPICS: Final = (
    Column("topic", is_text=True),
    Column("schema", is_text=True, spare=4),
    Column("messages"),
    Column("rate [Hz]", spare=3),
    Column("first [s]", spare=2),
    Column("last [s]", spare=1),
)


def info(
    log: Annotated[
        Path, typer.Argument(metavar="LOG.mcap", help="A log, or the .part of one whose flight was killed.")
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Show what is in a log: outcome, topics, metadata, attachments.

    Each topic has its count and rate.

    Says how long it is and whether it is complete, and checks every checksum on the way. A log that is cut short is
    shown up to where it is whole.
    """
    from waypointctl.log.reader import open_log

    opened = open_log(log, allow_truncated=True)
    if as_json:
        typer.echo(json.dumps(_record(opened)))
    else:
        _show(opened)


def _record(log: LogReader) -> dict[str, Any]:
    return {
        "log": str(log.path),
        "complete": log.is_complete,
        "size_bytes": log.index.size_bytes,
        "library": log.index.library,
        "messages": log.message_count,
        "start_ns": log.start_ns,
        "end_ns": log.end_ns,
        "duration_s": log.duration_s,
        "outcome": _outcome(log),
        "topics": [asdict(topic) | {"rate_hz": topic.rate_hz} for topic in log.topics.values()],
        "attachments": [{"name": name, "size_bytes": len(data)} for name, data in log.attachments.items()],
        "metadata": dict(log.metadata),
    }


def _outcome(log: LogReader) -> str | None:
    """Return the outcome of the flight, None if the log has none."""
    from waypointctl.replay.summary_builder import summary_of_events

    events = summary_of_events(log)
    return events.ending if events.has_end else None


def _show(log: LogReader) -> None:
    from waypointctl.cli.console import console
    from waypointctl.cli.tui.tables import GridView

    out = console()
    unbroken = not out.is_terminal  # for programs that look for a line
    outcome = _outcome(log)
    unsaid, whole = _ending(log)
    out.print(
        f"{printable(log.path)}: {log.duration_s:.3f} s of simulation, {log.message_count} messages", soft_wrap=unbroken
    )
    out.print(f"outcome: {unsaid if outcome is None else printable(outcome)}", soft_wrap=unbroken)
    written = f"{log.index.size_bytes:,} bytes, written by {printable(log.index.library)}, {whole}"
    out.print(written, soft_wrap=unbroken)
    for table in (_topic_table(log), _attachment_table(log), _metadata_table(log)):
        out.print()
        out.print(GridView(table))


def _ending(log: LogReader) -> tuple[str, str]:
    """Return the text for an outcome that the log does not have, and the state of the file's end."""
    from waypointctl.paths import is_being_written

    if log.is_complete:
        return "none, the log has no outcome event", "complete"
    if is_being_written(log.path):
        return "none yet, the flight is still running", "being written"
    return (
        "none, the log has no end (the flight was killed or is still running)",
        "cut short: its writer was killed, or it was not copied to its end",
    )


def _topic_table(log: LogReader) -> Grid:
    from waypointctl.units import seconds

    rows = []
    for topic in log.topics.values():
        rate = "" if topic.rate_hz is None else f"{topic.rate_hz:.1f}"
        times = ("" if time is None else f"{seconds(time):.3f}" for time in (topic.first_ns, topic.last_ns))
        rows.append((topic.name, topic.schema, str(topic.count), rate, *times))
    return Grid("", _TOPICS, tuple(rows))


def _attachment_table(log: LogReader) -> Grid:
    rows = ((name, f"{len(data):,}") for name, data in log.attachments.items())
    return Grid("", (Column("attachment", is_text=True), Column("bytes")), tuple(rows))


def _metadata_table(log: LogReader) -> Grid:
    return Grid("", (Column("metadata", is_text=True), Column("value", is_text=True)), tuple(log.metadata.items()))
