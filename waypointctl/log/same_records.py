"""Whether a log has the records that are written of its messages here, however they are chunked and compressed.

So it is for waypointctl's reader and for those of mcap, which are run too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from hashlib import blake2b
from typing import Final, NamedTuple

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage
from mcap import records as mcap
from mcap.reader import McapReader, NonSeekingReader, SeekingReader
from mcap_protobuf.schema import build_file_descriptor_set

from waypointctl.log.chunk import Channel
from waypointctl.log.comparison import Diverged, Divergence
from waypointctl.log.header import Attachment, LogHeader
from waypointctl.log.opening import DAMAGE, open_file
from waypointctl.log.reader import LogReader
from waypointctl.log.records import RawMessage, shown
from waypointctl.log.writer import LogEncoder

_ENCODING: Final = "protobuf"


def compare_records(log: LogReader, header: LogHeader) -> int:
    """Encode a log's messages again; return how many records were compared with those of the log.

    Raises:
        Diverged: at the first attachment, metadata, channel, schema or message that differs.
        LogError: a message of the log cannot be read.
    """
    comparison = _Comparison(log)
    encoder = LogEncoder(comparison, header)
    for message in log.messages():
        encoder(message)
    encoder.finish()
    return comparison.count


class _Comparison:
    """Holds what is to be written against what the log has, record by record."""

    def __init__(self, log: LogReader) -> None:
        self.count = 0
        self._log = log
        self._found = log.raw_messages()
        self._attached: set[str] = set()
        self._topics: list[str] = []  # by channel, as they are opened
        self._schemas: set[int] = set()  # that those have

    def attach(self, attachment: Attachment) -> None:
        name = attachment.name
        found = self._log.attachments.get(name), self._log.index.media_types.get(name)
        if found != (attachment.data, attachment.media_type):
            here = "nothing" if found[0] is None else f"{found[1]}, {shown(found[0])}"
            self._refuse("attachment", name, here, f"{attachment.media_type}, {shown(attachment.data)}")
        self._attached.add(name)
        self.count += 1

    def describe(self, name: str, metadata: Mapping[str, str]) -> None:
        found = self._log.metadata
        for key in [*metadata, *found]:
            if found.get(key) != metadata.get(key):
                self._refuse("metadata", key, found.get(key, "nothing"), metadata.get(key, "nothing"))
        self.count += 1

    def open(self, topic: str, schema: type[ProtobufMessage]) -> Channel:
        contents = self._log.index
        channel = next((it for it in contents.channels.values() if it.topic == topic), None)
        if channel is None:
            self._refuse("file", f"channel of {topic}", "nothing", f"a channel of {schema.DESCRIPTOR.full_name}")
        else:
            if (channel.message_encoding, channel.metadata) != (_ENCODING, {}):
                self._refuse("file", f"channel of {topic}", channel.message_encoding, f"{_ENCODING}, without metadata")
            found = contents.schemas.get(channel.schema_id)
            if found is None or (found.name, found.encoding) != (schema.DESCRIPTOR.full_name, _ENCODING):
                self._refuse("file", f"schema of {topic}", "another", f"{schema.DESCRIPTOR.full_name} in {_ENCODING}")
            elif not _same_fields(found.data, schema):
                self._refuse("file", f"schema of {topic}", shown(found.data), f"the fields of {found.name}")
            self._schemas.add(channel.schema_id)
        self.count += 2
        self._topics.append(topic)
        return Channel(len(self._topics) - 1)

    def write(self, channel: Channel, log_time_ns: int, publish_time_ns: int, data: bytes) -> None:
        topic = self._topics[channel.id]
        expected = RawMessage(0, channel.sequence, log_time_ns, publish_time_ns, data)
        channel.sequence += 1
        found = next(self._found, None)
        if found is None or (found[0], found[1][1:]) != (topic, expected[1:]):
            self._refuse(topic, "bytes", _named(found), _named((topic, expected)), log_time_ns)
        self.count += 1

    def flush(self) -> None:
        """Leave it open where a chunk ends."""

    def finish(self) -> None:
        more = next(self._found, None)
        if more is not None:
            self._refuse(more[0], "bytes", _named(more), "nothing", more[1].log_time_ns)
        for what, found, known in (
            ("attachment", self._log.attachments, self._attached),
            ("channel of", {it.topic: it for it in self._log.index.channels.values()}, set(self._topics)),
            ("schema of no channel:", self._log.index.schemas, self._schemas),
        ):
            unknown = next((name for name in found if name not in known), None)
            if unknown is not None:
                self._refuse("file", f"{what} {unknown}", "a record of it", "nothing")

    def _refuse(self, topic: str, component: str, found: str, expected: str, time_ns: int = 0) -> None:
        raise Diverged(Divergence(-1, time_ns, topic, component, found, expected))


def _same_fields(data: bytes, schema: type[ProtobufMessage]) -> bool:
    """Tell whether a schema in a log describes the fields that are written here, whatever packed the description."""
    try:
        found = FileDescriptorSet.FromString(data)
    except DecodeError:
        return False
    ours = build_file_descriptor_set(schema)
    same_files = {it.name: it for it in found.file} == {it.name: it for it in ours.file}
    return same_files and found.ByteSize() == ours.ByteSize()  # nothing twice, or in a field that nobody knows


def _named(message: tuple[str, RawMessage] | None) -> str:
    if message is None:
        return "nothing"
    topic, raw = message
    return f"message {raw.sequence} on {topic}, {shown(raw.data)}"


_BYTES: Final = 32  # of a hash


class _Digest(NamedTuple):
    """How many items there are, and the sum of their hashes: the same in any order."""

    messages: int
    total: int


def compare_readers(log: LogReader) -> None:
    """Read a log with mcap's readers, every message with its channel and schema.

    Memory does not grow with the log: messages are compared as a number and a sum of hashes.

    Raises:
        Diverged: one of them gives other messages, attachments or metadata.
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


def _kind(channel: mcap.Channel, schema: mcap.Schema | None) -> tuple[object, ...]:
    said = (channel.topic, channel.message_encoding)
    return said if schema is None else (*said, schema.name, schema.encoding, hash(schema.data))


def _digest(items: Iterable[tuple[object, ...]]) -> _Digest:
    messages, total = 0, 0
    for item in items:
        messages += 1
        total += int.from_bytes(blake2b(repr(item).encode(), digest_size=_BYTES).digest())
    return _Digest(messages, total)


def _differ(reader: str, found: str, expected: str) -> Diverged:
    return Diverged(Divergence(-1, 0, "file", reader, found, expected))
