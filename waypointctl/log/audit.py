"""Checks that a log matches its index completely, so that every reader shows the same."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any, Final, NoReturn

from mcap import records as mcap
from mcap.opcode import Opcode

from waypointctl.log.channels import Summary, attachment_index
from waypointctl.log.chunk import chunk_index, encoded
from waypointctl.log.comparison import Diverged, Divergence, brief, kind_of
from waypointctl.log.opening import DAMAGE, MAGIC, open_file
from waypointctl.log.reader import LogReader
from waypointctl.log.records import Record, body_stream, chunk_bytes, inner_records, raw_message, records, shown

_HEAD_BYTES: Final = 9  # opcode and length of a record
_DATA: Final = (Opcode.ATTACHMENT, Opcode.METADATA, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.DATA_END)
_SUMMARY: Final = (
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
    Opcode.SUMMARY_OFFSET,
    Opcode.FOOTER,
)
# mcap names the class of each record after its opcode.
_TYPES: Final[dict[int, Any]] = {
    opcode: getattr(mcap, opcode.name.title().replace("_", "")) for opcode in (Opcode.HEADER, *_DATA, *_SUMMARY)
}


def audit(log: LogReader) -> None:
    """Check every record of a log's file against every other.

    Allowed is what a writer of MCAP makes of a flight: a header, attachments with names of their own, one metadata
    record, chunks of schemas, channels and messages, each followed by its message indexes, the end of the data, a
    summary that lists exactly these, a footer. How they are chunked and compressed is free.

    Raises:
        Diverged: at the first record that is hidden, unknown, misplaced, duplicated, redefined, not in the index, or
            not as in the index.
    """
    found = _Audit()
    with open_file(log.path) as stream:
        for record in records(stream, len(MAGIC), log.index.size_bytes):
            try:
                found.take(record)
            except DAMAGE as error:
                where = f"{kind_of(record.opcode)} at byte {record.offset}"
                expected = f"{kind_of(record.opcode)} that can be read"
                raise Diverged(Divergence(-1, 0, "file", where, str(error), expected)) from error


class _Audit:
    """Takes the records of a file in their order, and knows what its index has to be."""

    def __init__(self) -> None:
        self._allowed: tuple[Opcode, ...] = (Opcode.HEADER,)
        self._record = Record(0, 0, b"")
        self._names: set[str] = set()  # of attachments
        self._definitions: dict[tuple[int, int], bytes] = {}  # of schemas and channels, by opcode and id
        self._topics: set[str] = set()
        self._summary = Summary()  # what the file's has to be
        self._unindexed: dict[int, list[tuple[int, int]]] = {}  # of the last chunk: log times and offsets by channel
        self._listed: Counter[bytes] = Counter()  # what the summary has to list, each record as its bytes
        self._groups: dict[int, tuple[int, int]] = {}  # of the summary: first and last byte by opcode
        self._summary_start = 0
        self._offsets_start = 0

    def take(self, record: Record) -> None:
        """Check one record."""
        self._record = record
        if record.opcode not in self._allowed:
            allowed = " or ".join(kind_of(opcode) for opcode in self._allowed) or "the end of the file"
            self._refuse(f"{kind_of(record.opcode)}, {shown(record.body)}", allowed)
        it = _TYPES[record.opcode].read(body_stream(record.body))
        if encoded(it) != record.raw:
            self._refuse(f"{kind_of(record.opcode)}, {shown(record.body)}", "no more bytes than it declares")
        if self._unindexed and record.opcode != Opcode.MESSAGE_INDEX:
            self._refuse(kind_of(record.opcode), "a message index of each channel in the chunk before")
        if self._summary_start and record.opcode != Opcode.FOOTER:
            self._take_summary(record, it)
        else:
            self._take_data(record, it)

    def _take_data(self, record: Record, it: Any) -> None:
        match it:
            case mcap.Header():
                self._require(not it.profile, f"the profile {brief(it.profile)!r}", "no profile")
                self._allowed = _DATA
            case mcap.Attachment():
                self._require(it.name not in self._names, f"a second attachment {brief(it.name)!r}", "one of each name")
                self._require(not (it.log_time or it.create_time), "a time of an attachment", "none: no clock is read")
                self._names.add(it.name)
                self._summary.attachments.append(attachment_index(it, record.offset, len(record.raw)))
            case mcap.Metadata():
                self._require(not self._summary.metadata, "a second metadata record", "one")
                self._summary.metadata.append(mcap.MetadataIndex(record.offset, len(record.raw), it.name))
            case mcap.Chunk():
                self._take_chunk(record, it)
            case mcap.MessageIndex():
                self._take_message_index(record, it)
            case mcap.DataEnd():
                self._require(it.data_section_crc != 0, "no checksum", "a checksum of the data")
                self._end_data(record)
            case mcap.Footer():
                self._end_summary(record, it)

    def _take_chunk(self, record: Record, chunk: mcap.Chunk) -> None:
        data = chunk_bytes(record)
        times: list[int] = []
        offset = 0
        for opcode, body in inner_records(data):
            if opcode == Opcode.MESSAGE:
                raw = raw_message(body)
                known = (Opcode.CHANNEL, raw.channel) in self._definitions
                self._require(known, f"a message of channel {raw.channel}", "a message of a channel that is defined")
                self._unindexed.setdefault(raw.channel, []).append((raw.log_time_ns, offset))
                self._summary.counts[raw.channel] += 1
                times.append(raw.log_time_ns)
            else:
                self._define(opcode, body)
            offset += _HEAD_BYTES + len(body)
        said = (chunk.message_start_time, chunk.message_end_time, chunk.uncompressed_size, chunk.uncompressed_crc != 0)
        true = (min(times, default=0), max(times, default=0), len(data), True)
        self._require(said == true, f"times and size {said[:3]}", f"{true[:3]} and a checksum")
        self._summary.chunks.append(chunk_index(chunk, record.offset, len(record.raw)))

    def _define(self, opcode: int, body: bytes) -> None:
        where = f"{kind_of(opcode)}, {shown(body)}"
        self._require(opcode in (Opcode.SCHEMA, Opcode.CHANNEL), where, "schemas, channels and messages in a chunk")
        it = _TYPES[opcode].read(body_stream(body))
        raw = encoded(it)
        self._require(raw == Record(0, opcode, body).raw, where, "no more bytes than it declares")
        first = self._definitions.setdefault((opcode, it.id), raw)
        self._require(first == raw, f"{kind_of(opcode)} {it.id} defined again as another", "one definition of each")
        if first is raw and opcode == Opcode.CHANNEL:
            self._require(
                it.topic not in self._topics, f"a second channel of {brief(it.topic)}", "one channel of each topic"
            )
            self._topics.add(it.topic)
            self._summary.channels.append(it)
        elif first is raw:
            self._summary.schemas.append(it)

    def _take_message_index(self, record: Record, it: mcap.MessageIndex) -> None:
        entries = self._unindexed.pop(it.channel_id, None)
        self._require(entries is not None, f"an index of channel {it.channel_id}", "one of each channel in the chunk")
        true = sorted(entries or [])
        self._require(sorted(it.records) == true, f"{len(it.records)} entries", f"those of {len(true)} messages")
        index = self._summary.chunks[-1]
        index.message_index_offsets[it.channel_id] = record.offset
        index.message_index_length += len(record.raw)

    def _end_data(self, record: Record) -> None:
        self._allowed = _SUMMARY
        self._summary_start = record.offset + len(record.raw)
        for records_of_kind in self._summary.groups().values():
            self._listed.update(encoded(_sorted(it)) for it in records_of_kind)

    def _take_summary(self, record: Record, it: Any) -> None:
        end = record.offset + len(record.raw)
        if isinstance(it, mcap.SummaryOffset):
            self._offsets_start = self._offsets_start or record.offset
            start, last = self._groups.pop(it.group_opcode, (0, 0))
            self._require((it.group_start, it.group_length) == (start, last - start), "a place", "that of its group")
            return
        raw = encoded(_sorted(it))
        what = kind_of(record.opcode)
        self._require(self._listed[raw] > 0, f"{what}, {shown(record.body)}", f"{what} of what is in the file, once")
        self._require(not self._offsets_start, what, "summary offsets after all that they point to")
        self._listed[raw] -= 1
        begin, last = self._groups.get(record.opcode, (record.offset, record.offset))
        self._require(last == record.offset, f"a second group of {what}", "one of each kind")
        self._groups[record.opcode] = (begin, end)

    def _end_summary(self, record: Record, it: mcap.Footer) -> None:
        self._allowed = ()
        missing = next((raw for raw, count in self._listed.items() if count > 0), None)
        if missing is not None:
            self._refuse("the end of the summary", f"{kind_of(missing[0])} of what is in the file")
        said = (it.summary_start, it.summary_offset_start, it.summary_crc != 0)
        true = (self._summary_start, self._offsets_start, True)
        self._require(said == true, f"summary at {said[:2]}", f"{true[:2]} and a checksum")

    def _require(self, holds: bool, found: str, expected: str) -> None:
        if not holds:
            self._refuse(found, expected)

    def _refuse(self, found: str, expected: str) -> NoReturn:
        where = f"{kind_of(self._record.opcode)} at byte {self._record.offset}"
        raise Diverged(Divergence(-1, 0, "file", where, found, expected))


def _sorted(record: Any) -> Any:
    """Return a record with its channels in order, which is the writer's choice."""
    match record:
        case mcap.ChunkIndex():
            return replace(record, message_index_offsets=dict(sorted(record.message_index_offsets.items())))
        case mcap.Statistics():
            return replace(record, channel_message_counts=dict(sorted(record.channel_message_counts.items())))
        case _:
            return record
