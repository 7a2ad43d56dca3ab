"""The file under a log: byte for byte what mcap's own writer makes of the same messages, and found by its readers."""

from __future__ import annotations

import io
import tempfile
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.reader import McapReader, NonSeekingReader, SeekingReader
from mcap.records import Channel, Chunk, Footer, Message, MessageIndex, Schema, SummaryOffset
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import register_schema

from tests.log.fake_flight import header
from waypointctl import __version__
from waypointctl.log.channels import CHUNK_BYTES, ChannelWriter
from waypointctl.log.chunk import ZSTD_LEVEL
from waypointctl.log.header import Attachment
from waypointctl.log.messages import Observation
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.log.records import body_stream, inner_records, raw_message, records
from waypointctl.log.writer import LogWriter
from waypointctl.units import NS_PER_S

SCHEMAS = {"/state": pb.State, "/again": pb.State, "/silent": pb.Ack, "/event": pb.Event}
ATTACHMENTS = (Attachment("a.txt", "text/plain", b"a"), Attachment("none", "", b""))
FACTS = {"seed": "7", "ü": ""}


@dataclass(frozen=True)
class Said:
    topic: str
    log_time_ns: int
    publish_time_ns: int
    data: bytes


times = st.integers(0, 4 * NS_PER_S)
talk = st.lists(st.builds(Said, st.sampled_from(["/state", "/again", "/event"]), times, times, st.binary(max_size=90)))


def ours(talk: list[Said], flushed: Collection[int] = ()) -> bytes:
    """Write all that was said; flush before those of these numbers."""
    stream = io.BytesIO()
    writer = ChannelWriter(stream)
    for attachment in ATTACHMENTS:
        writer.attach(attachment)
    writer.describe("facts", FACTS)
    channels = {topic: writer.open(topic, schema) for topic, schema in SCHEMAS.items()}
    for number, said in enumerate(talk):
        if number in flushed:
            writer.flush()
        writer.write(channels[said.topic], said.log_time_ns, said.publish_time_ns, said.data)
    writer.finish()
    return stream.getvalue()


def theirs(talk: list[Said], chunk_lengths: list[int]) -> bytes:
    """Write the same with mcap's writer, which is told when to end a chunk and cannot be told how hard to compress."""
    stream = io.BytesIO()
    writer = Writer(stream, 1 << 40, CompressionType.ZSTD, enable_data_crcs=True)
    writer.start(library=f"waypointctl {__version__}")
    for it in ATTACHMENTS:
        writer.add_attachment(0, 0, it.name, it.media_type, it.data)
    writer.add_metadata("facts", FACTS)
    schemas: dict[object, int] = {}
    channels = {}
    for topic, schema in SCHEMAS.items():
        if schema not in schemas:
            schemas[schema] = register_schema(writer, schema)
        channels[topic] = writer.register_channel(topic, "protobuf", schemas[schema])
    sequences: Counter[str] = Counter()
    rest = iter(talk)
    with patch("zstandard.compress", zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress):
        for length in chunk_lengths:
            for _, said in zip(range(length), rest, strict=False):
                sequence, sequences[said.topic] = sequences[said.topic], sequences[said.topic] + 1
                writer.add_message(channels[said.topic], said.log_time_ns, said.data, said.publish_time_ns, sequence)
            writer.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    return stream.getvalue()


def chunk_records(chunk: Chunk) -> bytes:
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    return stream.read(length)


def messages_by_chunk(file: bytes) -> list[int]:
    stream = StreamReader(io.BytesIO(file), emit_chunks=True, validate_crcs=True)
    chunks = [record for record in stream.records if isinstance(record, Chunk)]
    return [sum(opcode == Opcode.MESSAGE for opcode, _ in inner_records(chunk_records(chunk))) for chunk in chunks]


@settings(deadline=None)
@given(talk, st.sets(st.integers(0, 20)))
def test_it_is_the_file_that_mcap_writes(talk: list[Said], flushed: set[int]) -> None:
    file = ours(talk, flushed)
    lengths = messages_by_chunk(file)
    assert sum(lengths) == len(talk)
    assert file == theirs(talk, lengths)


def test_it_is_the_file_that_mcap_writes_where_chunks_are_full() -> None:
    sizes = [CHUNK_BYTES, 1, CHUNK_BYTES // 2, CHUNK_BYTES // 2, 3 * CHUNK_BYTES, 0, 0]
    talk = [Said("/state", 5, 5, bytes(size)) for size in sizes]
    file = ours(talk)
    lengths = messages_by_chunk(file)
    assert lengths == [1, 2, 1, 1, 2]
    assert file == theirs(talk, lengths)


@settings(deadline=None)
@given(st.lists(times))
def test_a_chunk_ends_when_a_later_second_begins(log_times_ns: list[int]) -> None:
    latest, lengths = 0, [0]
    for time_ns in log_times_ns:
        if time_ns // NS_PER_S > latest:
            latest = time_ns // NS_PER_S
            lengths.append(0)
        lengths[-1] += 1
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mcap"
        with LogWriter(path, header()) as sink:
            for time_ns in log_times_ns:
                sink(Observation(time_ns, 0, np.zeros(3)))
        _, *found = messages_by_chunk(path.read_bytes())  # the first has what viewers see before take-off
    assert found == [length for length in lengths if length]


def found(
    reader: McapReader, topics: list[str] | None = None, start_ns: int | None = None, end_ns: int | None = None
) -> list[tuple[str, Message]]:
    wanted = reader.iter_messages(topics, log_time_order=False, starting_at=start_ns, ending_before=end_ns)
    return [(channel.topic, message) for _, channel, message in wanted]


@pytest.mark.parametrize("topics", [None, ["/state"], ["/command", "/ack"], ["/tf", "/event"], ["/none"]])
@pytest.mark.parametrize(
    ("start_ns", "end_ns"), [(None, None), (NS_PER_S, 2 * NS_PER_S), (1_280_000_000, 1_280_000_001), (10**12, None)]
)
def test_a_reader_that_seeks_finds_what_one_that_reads_all_finds(
    log_path: Path, topics: list[str] | None, start_ns: int | None, end_ns: int | None
) -> None:
    with open(log_path, "rb") as stream:
        every = found(NonSeekingReader(stream, validate_crcs=True))
        stream.seek(0)
        sought = found(SeekingReader(stream, validate_crcs=True), topics, start_ns, end_ns)
    expected = [
        (topic, message)
        for topic, message in every
        if (topics is None or topic in topics) and (start_ns or 0) <= message.log_time < (end_ns or 10**18)
    ]
    assert sought == expected


def test_statistics_are_those_of_the_messages(log_path: Path) -> None:
    with open(log_path, "rb") as stream:
        every = [message for _, message in found(NonSeekingReader(stream, validate_crcs=True))]
        stream.seek(0)
        summary = SeekingReader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    statistics = summary.statistics
    assert statistics is not None
    assert statistics.channel_message_counts == Counter(message.channel_id for message in every)
    assert statistics.message_count == len(every)
    assert statistics.message_start_time == min(message.log_time for message in every)
    assert statistics.message_end_time == max(message.log_time for message in every)
    assert (
        statistics.chunk_count == len(summary.chunk_indexes) == 6
    )  # the first before take-off, one a second, the last instant
    assert (statistics.schema_count, statistics.channel_count) == (len(summary.schemas), len(summary.channels))
    assert (statistics.attachment_count, statistics.metadata_count) == (3, 1)


def test_indexes_point_at_what_they_say(log_path: Path) -> None:
    size = log_path.stat().st_size
    with open(log_path, "rb") as stream:
        summary = SeekingReader(stream, validate_crcs=True).get_summary()
        assert summary is not None
        for index in summary.chunk_indexes:
            found = records(stream, index.chunk_start_offset, size)
            chunk = Chunk.read(body_stream(next(found).body))
            bodies = {offset: raw_message(body) for offset, body in message_bodies(chunk_records(chunk)).items()}
            for channel, offset in index.message_index_offsets.items():
                entries = MessageIndex.read(body_stream(next(records(stream, offset, size)).body)).records
                assert entries == [(body.log_time_ns, at) for at, body in bodies.items() if body.channel == channel]
            assert {body.channel for body in bodies.values()} == set(index.message_index_offsets)


def message_bodies(chunk: bytes) -> dict[int, bytes]:
    """Return the bodies of a chunk's messages by the offset of their records."""
    bodies, offset = {}, 0
    for opcode, body in inner_records(chunk):
        if opcode == Opcode.MESSAGE:
            bodies[offset] = body
        offset += 9 + len(body)
    return bodies


def test_summary_offsets_point_at_whole_groups(log_path: Path) -> None:
    size = log_path.stat().st_size
    with open(log_path, "rb") as stream:
        footer = next(
            Footer.read(body_stream(it.body)) for it in records(stream, 8, size) if it.opcode == Opcode.FOOTER
        )
        section = list(records(stream, footer.summary_start, size))
    groups = [SummaryOffset.read(body_stream(it.body)) for it in section if it.opcode == Opcode.SUMMARY_OFFSET]
    assert [group.group_opcode for group in groups] == [
        Opcode.SCHEMA,
        Opcode.CHANNEL,
        Opcode.STATISTICS,
        Opcode.CHUNK_INDEX,
        Opcode.ATTACHMENT_INDEX,
        Opcode.METADATA_INDEX,
    ]
    assert groups[0].group_start == footer.summary_start
    for group in groups:
        members = [it for it in section if it.opcode == group.group_opcode]
        assert group.group_start == members[0].offset
        assert group.group_length == sum(len(it.raw) for it in members)


def test_schemas_and_channels_stand_before_their_messages_and_in_the_summary(log_path: Path) -> None:
    with open(log_path, "rb") as stream:
        summary = SeekingReader(stream).get_summary()
        stream.seek(0)
        inner = list(StreamReader(stream, validate_crcs=True).records)
    assert summary is not None
    first_message = next(place for place, record in enumerate(inner) if isinstance(record, Message))
    before = inner[:first_message]
    assert {record.id: record for record in before if isinstance(record, Schema)} == summary.schemas
    assert {record.id: record for record in before if isinstance(record, Channel)} == summary.channels
