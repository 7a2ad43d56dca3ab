"""Whether a log has the records that are written of its messages here, however they are chunked and compressed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage
from mcap_protobuf.schema import build_file_descriptor_set

from waypointctl.log.chunk import Channel
from waypointctl.log.comparison import FileDifference, FileDiffers
from waypointctl.log.encoder import LogEncoder
from waypointctl.log.header import Attachment, LogHeader
from waypointctl.log.reader import LogReader
from waypointctl.log.records import RawMessage, shown

_ENCODING: Final = "protobuf"


def compare_records(log: LogReader, header: LogHeader) -> int:
    """Encode a log's messages again; return how many records were compared with those of the log.

    Raises:
        FileDiffers: at the first attachment, metadata, channel, schema or message that differs.
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
        raise FileDiffers(FileDifference(time_ns, topic, component, found, expected))


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
