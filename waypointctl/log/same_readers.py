"""Whether the mcap library's own readers give of a log what ours gives: the one that streams and the one that seeks."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import blake2b
from typing import Final, NamedTuple

from mcap.reader import McapReader, NonSeekingReader, SeekingReader
from mcap.records import Channel, Schema

from waypointctl.log.comparison import FileDifference, FileDiffers
from waypointctl.log.opening import DAMAGE, open_file
from waypointctl.log.reader import LogReader

_BYTES: Final = 32  # of a hash


class _Digest(NamedTuple):
    """How many items there are, and the sum of their hashes: the same in any order."""

    messages: int
    total: int


def compare_readers(log: LogReader) -> None:
    """Read a log with mcap's readers, every message with its channel and schema.

    Memory does not grow with the log: messages are compared as a number and a sum of hashes.

    Raises:
        FileDiffers: one of them gives other messages, attachments or metadata.
    """
    contents = log.index
    attached = [(name, contents.media_types[name], data) for name, data in log.attachments.items()]
    ours = (_of_log(log), attached, [dict(log.metadata)])
    with open_file(log.path) as stream:
        try:
            streamed = _messages(NonSeekingReader(stream, validate_crcs=True), in_order=False)
            stream.seek(0)
            seeking = SeekingReader(stream, validate_crcs=True)
            # In the order of their times: so the reader holds no more than the chunks of one moment.
            sought = _messages(seeking, in_order=True)
            files = [(it.name, it.media_type, it.data) for it in seeking.iter_attachments()]
            theirs = (sought, files, [it.metadata for it in seeking.iter_metadata()])
        except DAMAGE as error:
            raise _differ("mcap's readers", str(error) or type(error).__name__, "no error") from error
    if streamed != ours[0]:
        raise _differ(
            "mcap's streaming reader", f"{streamed.messages} messages", f"{ours[0].messages} messages of the log"
        )
    if theirs != ours:
        raise _differ("mcap's seeking reader", f"{sought.messages} messages", f"{ours[0].messages} messages of the log")


def _of_log(log: LogReader) -> _Digest:
    channels = {it.topic: it for it in log.index.channels.values()}
    schemas = log.index.schemas
    return _digest(
        (*_kind(channels[topic], schemas.get(channels[topic].schema_id)), *raw[1:]) for topic, raw in log.raw_messages()
    )


def _messages(reader: McapReader, *, in_order: bool) -> _Digest:
    return _digest(
        (*_kind(channel, schema), it.sequence, it.log_time, it.publish_time, it.data)
        for schema, channel, it in reader.iter_messages(log_time_order=in_order)
    )


def _kind(channel: Channel, schema: Schema | None) -> tuple[object, ...]:
    said = (channel.topic, channel.message_encoding)
    return said if schema is None else (*said, schema.name, schema.encoding, hash(schema.data))


def _digest(items: Iterable[tuple[object, ...]]) -> _Digest:
    messages, total = 0, 0
    for item in items:
        messages += 1
        total += int.from_bytes(blake2b(repr(item).encode(), digest_size=_BYTES).digest())
    return _Digest(messages, total)


def _differ(reader: str, found: str, expected: str) -> FileDiffers:
    return FileDiffers(FileDifference(0, "file", reader, found, expected))
