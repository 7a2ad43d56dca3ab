"""Ways in which a file can show one reader another flight than it shows the next, with every checksum right."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap import records as mcap
from mcap.opcode import Opcode

from tests.log.forging import HEAD_BYTES, Chunk, Forgery, seal
from waypointctl.log.chunk import encoded
from waypointctl.log.opening import MAGIC
from waypointctl.log.records import Record, body_stream, raw_message

PRIVATE: Final = 0x80  # the first opcode that MCAP leaves to everybody


def hidden_chunk(forged: Forgery) -> None:
    """Show the reader that seeks another chunk than the one that streams: it is in a record that nobody knows."""
    forged.chunks[1].is_indexed = False
    decoy = Chunk(forged.chunks[1].inner[:-1])
    found: list[mcap.ChunkIndex] = []

    def hide(offset: int) -> bytes:
        data, index, _ = seal(decoy, offset + HEAD_BYTES)
        found[:] = [index]
        return Record(0, PRIVATE, data).raw

    forged.data.insert(forged.data.index(forged.chunks[1]), hide)
    forged.summary = lambda listed: _with(listed, mcap.ChunkIndex, found[0])


def index_that_hides_a_chunk(forged: Forgery) -> None:
    forged.summary = lambda listed: _without_first(listed, mcap.ChunkIndex)


def chunk_listed_twice(forged: Forgery) -> None:
    def twice(listed: list[mcap.McapRecord]) -> Iterable[mcap.McapRecord]:
        return _with(listed, mcap.ChunkIndex, next(it for it in listed if isinstance(it, mcap.ChunkIndex)))

    forged.summary = twice


def chunk_not_indexed(forged: Forgery) -> None:
    forged.chunks[1].is_indexed = False


def index_of_other_times(forged: Forgery) -> None:
    forged.chunks[1].index_lies = {"message_start_time": 0, "message_end_time": 0}


def index_without_a_channel(forged: Forgery) -> None:
    forged.chunks[1].index_lies = {"message_index_offsets": {}}


def chunk_of_other_times(forged: Forgery) -> None:
    forged.chunks[1].lies = {"message_start_time": 1 << 62, "message_end_time": 1 << 62}


def chunk_without_a_checksum(forged: Forgery) -> None:
    forged.chunks[1].lies = {"uncompressed_crc": 0}


def other_statistics(forged: Forgery) -> None:
    def change(it: mcap.McapRecord) -> mcap.McapRecord:
        return replace(it, message_count=7) if isinstance(it, mcap.Statistics) else it

    forged.summary = lambda listed: map(change, listed)


def swapped_fields(forged: Forgery) -> None:
    """Call qpos qvel, and qvel qpos: every other reader shows the one for the other."""

    def swap(schema: mcap.Schema) -> mcap.Schema:
        described = FileDescriptorSet.FromString(schema.data)
        for message in described.file[-1].message_type:
            fields = {it.name: it for it in message.field}
            if message.name == "State":
                fields["qpos"].name, fields["qvel"].name = "qvel", "qpos"
        return replace(schema, data=described.SerializeToString())

    _redefine(forged, Opcode.SCHEMA, "waypointctl.State", swap)


def schema_of_another_name(forged: Forgery) -> None:
    _redefine(forged, Opcode.SCHEMA, "waypointctl.State", lambda schema: replace(schema, name="waypointctl.Reward"))


def schema_with_more(forged: Forgery) -> None:
    """Hide bytes in a field that no description of schemas has."""
    hidden = b"\xba\x3e\x06hidden"
    _redefine(forged, Opcode.SCHEMA, "waypointctl.State", lambda schema: replace(schema, data=schema.data + hidden))


def schema_of_nothing(forged: Forgery) -> None:
    _define(forged.chunks[0], mcap.Schema(900, b"hidden", "protobuf", "waypointctl.State"), at=0)


def channel_of_another_encoding(forged: Forgery) -> None:
    _redefine(forged, Opcode.CHANNEL, "/state", lambda channel: replace(channel, message_encoding="json"))


def channel_with_metadata(forged: Forgery) -> None:
    _redefine(forged, Opcode.CHANNEL, "/state", lambda channel: replace(channel, metadata={"frame": "other"}))


def channel_of_another_topic(forged: Forgery) -> None:
    _redefine(forged, Opcode.CHANNEL, "/state", lambda channel: replace(channel, topic="/states"))


def channel_defined_again(forged: Forgery) -> None:
    """Let the last chunk call what is on /state /action."""
    channel = mcap.Channel(forged.channel("/state"), "/action", "protobuf", {}, 1)
    _define(forged.chunks[-1], channel, at=len(forged.chunks[-1].inner))


def second_channel_of_a_topic(forged: Forgery) -> None:
    _define(forged.chunks[0], mcap.Channel(999, "/state", "protobuf", {}, 1), at=len(forged.chunks[0].inner))


def topic_of_its_own(forged: Forgery) -> None:
    _define(forged.chunks[0], mcap.Channel(999, "/more", "protobuf", {}, 1), at=len(forged.chunks[0].inner))


def message_outside_a_chunk(forged: Forgery) -> None:
    first = [record for record in forged.chunks[0].inner if record[0] != Opcode.MESSAGE]
    body = forged.messages("/state")[0][0].inner[forged.messages("/state")[0][1]][1]
    loose = b"".join(Record(0, opcode, body).raw for opcode, body in [*first, (Opcode.MESSAGE, body)])
    forged.data.insert(forged.data.index(forged.chunks[0]), loose)


def message_twice(forged: Forgery) -> None:
    chunk, at = forged.messages("/state")[3]
    chunk.inner.insert(at, chunk.inner[at])


def message_missing(forged: Forgery) -> None:
    chunk, at = forged.messages("/tf")[3]
    del chunk.inner[at]


def message_with_another_sequence(forged: Forgery) -> None:
    chunk, at = forged.messages("/tf")[3]
    raw = raw_message(chunk.inner[at][1])
    message = mcap.Message(raw.channel, raw.log_time_ns, raw.data, raw.publish_time_ns, 77)
    chunk.inner[at] = (Opcode.MESSAGE, encoded(message)[9:])


def unknown_record_in_a_chunk(forged: Forgery) -> None:
    forged.chunks[1].inner.append((PRIVATE, b"hidden"))


def unknown_record(forged: Forgery) -> None:
    forged.data.append(Record(0, PRIVATE, b"hidden").raw)


def attachment_first(forged: Forgery) -> None:
    forged.data.insert(0, mcap.Attachment(0, 0, "mission.yaml", "application/yaml", b"name: another\n"))


def attachment_twice(forged: Forgery) -> None:
    forged.data.append(forged.attachment("mission.yaml"))


def attachment_more(forged: Forgery) -> None:
    forged.data.append(mcap.Attachment(0, 0, "notes.txt", "text/plain", b"hidden"))


def attachment_of_another_media_type(forged: Forgery) -> None:
    _replace(forged, forged.attachment("mission.yaml"), {"media_type": "text/html"})


def attachment_with_a_time(forged: Forgery) -> None:
    _replace(forged, forged.attachment("mission.yaml"), {"create_time": 5})


def metadata_first(forged: Forgery) -> None:
    forged.data.insert(0, mcap.Metadata("waypointctl", forged.metadata() | {"mission": "another"}))


def metadata_last(forged: Forgery) -> None:
    forged.data.append(mcap.Metadata("waypointctl", forged.metadata()))


def metadata_of_another_name(forged: Forgery) -> None:
    forged.data.append(mcap.Metadata("notes", {"outcome": "success"}))


def metadata_key_twice(forged: Forgery) -> None:
    """Let readers choose between two values of a key."""
    body = encoded(mcap.Metadata("waypointctl", {"seed": "8"}))[9 + 15 + 4 :]
    honest = next(part for part in forged.data if isinstance(part, mcap.Metadata))
    whole = encoded(honest)[9 + 15 + 4 :]
    name = encoded(mcap.Metadata("waypointctl", {}))[9:-4]
    record = name + (len(body) + len(whole)).to_bytes(4, "little") + body + whole
    forged.data[forged.data.index(honest)] = Record(0, Opcode.METADATA, record).raw


def bytes_at_a_records_end(forged: Forgery) -> None:
    honest = next(part for part in forged.data if isinstance(part, mcap.Metadata))
    forged.data[forged.data.index(honest)] = Record(0, Opcode.METADATA, encoded(honest)[9:] + b"hidden").raw


def header_of_another_profile(forged: Forgery) -> None:
    forged.header = replace(forged.header, profile="ros2")


def second_footer(forged: Forgery) -> None:
    forged.tail = encoded(mcap.Footer(0, 0, 0)) + MAGIC


def record_after_the_footer(forged: Forgery) -> None:
    forged.tail = Record(0, PRIVATE, b"hidden").raw + MAGIC


def no_summary(forged: Forgery) -> None:
    forged.summary = lambda listed: [mcap.Footer(0, 0, 0)]


ATTACKS: Final[dict[str, Callable[[Forgery], None]]] = {
    each.__name__: each
    for each in (
        hidden_chunk,
        index_that_hides_a_chunk,
        chunk_listed_twice,
        chunk_not_indexed,
        index_of_other_times,
        index_without_a_channel,
        chunk_of_other_times,
        chunk_without_a_checksum,
        other_statistics,
        swapped_fields,
        schema_of_another_name,
        schema_with_more,
        schema_of_nothing,
        channel_of_another_encoding,
        channel_with_metadata,
        channel_of_another_topic,
        channel_defined_again,
        second_channel_of_a_topic,
        topic_of_its_own,
        message_outside_a_chunk,
        message_twice,
        message_missing,
        message_with_another_sequence,
        unknown_record_in_a_chunk,
        unknown_record,
        attachment_first,
        attachment_twice,
        attachment_more,
        attachment_of_another_media_type,
        attachment_with_a_time,
        metadata_first,
        metadata_last,
        metadata_of_another_name,
        metadata_key_twice,
        bytes_at_a_records_end,
        header_of_another_profile,
        second_footer,
        record_after_the_footer,
        no_summary,
    )
}


def _with(listed: list[mcap.McapRecord], kind: type, more: mcap.McapRecord) -> list[mcap.McapRecord]:
    last = max((at for at, it in enumerate(listed) if isinstance(it, kind)), default=0)
    return [*listed[: last + 1], more, *listed[last + 1 :]]


def _without_first(listed: list[mcap.McapRecord], kind: type) -> list[mcap.McapRecord]:
    first = next(at for at, it in enumerate(listed) if isinstance(it, kind))
    return [*listed[:first], *listed[first + 1 :]]


def _define(chunk: Chunk, record: mcap.McapRecord, at: int) -> None:
    raw = encoded(record)
    chunk.inner.insert(at, (raw[0], raw[9:]))


def _redefine(forged: Forgery, opcode: Opcode, name: str, change: Callable[..., mcap.McapRecord]) -> None:
    kind, named = (mcap.Schema, "name") if opcode == Opcode.SCHEMA else (mcap.Channel, "topic")
    for chunk in forged.chunks:
        for at, (found, body) in enumerate(chunk.inner):
            record = kind.read(body_stream(body)) if found == opcode else None
            if record is not None and getattr(record, named) == name:
                chunk.inner[at] = (opcode, encoded(change(record))[9:])


def _replace(forged: Forgery, part: mcap.Attachment, fields: dict[str, object]) -> None:
    forged.data[forged.data.index(part)] = replace(part, **fields)  # type: ignore[arg-type]
