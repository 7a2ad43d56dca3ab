"""A log that is written anew over one that exists: nothing is written, every byte is compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from itertools import zip_longest
from typing import IO, Final, NamedTuple

from mcap import records as mcap
from mcap.opcode import Opcode

from waypointctl.log.opening import DAMAGE, MAGIC
from waypointctl.log.records import (
    CutShort,
    Record,
    body_stream,
    chunk_bytes,
    inner_records,
    raw_message,
    records,
    shown,
)

_SHOWN: Final = 80  # characters of a text
_NAMES: Final = {int(opcode): opcode.name.lower().replace("_", " ") for opcode in Opcode}


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first difference between a log and its replay."""

    step: int  # the control step; -1 for the file and its attachments
    time_ns: int  # log time of the message that differs; 0 where it is none
    topic: str  # of that message; "metadata", "attachment" or "file" where it is none
    component: str  # what differs; of a record of the file, with the byte where it begins
    logged: str  # what is in the log
    replayed: str  # what the replay makes

    @property
    def place(self) -> str:
        """The place as text."""
        if self.step >= 0:
            return f"at step {self.step} on {self.topic}, {self.component}"
        return f"in the file: {self.component if self.topic == 'file' else f'{self.topic}, {self.component}'}"


class Diverged(Exception):
    """The replay diverged from the log; `rounding`: a different rounding may be the cause."""

    def __init__(self, where: Divergence, *, rounding: bool = False) -> None:
        """Say where."""
        self.where = where
        self.rounding = rounding
        super().__init__(where.component)


class FileComparison:
    """A byte sink that holds what is written against the bytes of a file.

    Attributes:
        compared: how many bytes were found equal.
        differs: whether any byte was not.
    """

    def __init__(self, stream: IO[bytes], size: int) -> None:
        """Compare with `stream`, a file of `size` bytes that stands at its start."""
        self.compared = 0
        self._stream = stream
        self._size = size
        self._unlike: bytes | None = None  # what was to be written where the first difference is

    @property
    def differs(self) -> bool:
        """Whether what has been written differs from what is in the file."""
        return self._unlike is not None

    def write(self, data: bytes, /) -> int:
        """Compare whole records with what is in their place in the file."""
        if self._unlike is None:
            if self._stream.read(len(data)) == data:
                self.compared += len(data)
            else:
                self._unlike = data
        return len(data)

    def flush(self) -> None:
        """Do nothing: what was taken has been compared."""

    def difference(self, topics: Mapping[int, str]) -> Divergence | None:
        """Return where the file first differs, or goes on after the end; None where it does neither.

        Args:
            topics: by channel, as they were written.
        """
        if self._unlike is not None:
            return self._first_difference(self._unlike, topics)
        if self.compared == self._size:
            return None
        more = f"{self._size - self.compared} more bytes"
        return Divergence(-1, 0, "file", f"byte {self.compared}", more, "the end of the file")

    def _first_difference(self, data: bytes, topics: Mapping[int, str]) -> Divergence:
        offset = self.compared
        wanted = () if data == MAGIC else records(BytesIO(data + MAGIC), 0, len(data) + len(MAGIC))
        for record in wanted:
            expected = Record(offset, record.opcode, record.body)
            found = self._record_at(offset)
            if found is None or found.raw != expected.raw:
                return _difference(found, expected, topics)
            offset += len(expected.raw)
        return Divergence(-1, 0, "file", f"byte {offset}", "other bytes", "the magic that ends a file")

    def _record_at(self, offset: int) -> Record | None:
        try:
            return next(records(self._stream, offset, self._size), None)
        except CutShort:
            return None


class _Part(NamedTuple):
    """What is compared on its own in a record."""

    topic: str
    component: str
    text: str
    content: object
    time_ns: int = 0


def brief(text: str) -> str:
    """Return as much of a text of a file as is to be shown where it differs."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def kind_of(opcode: int) -> str:
    """Return what kind of record has this opcode, in words."""
    return _NAMES.get(opcode, f"record of the unknown kind {opcode:#04x}")


def _difference(found: Record | None, expected: Record, topics: Mapping[int, str]) -> Divergence:
    theirs = _parts(expected, topics)
    if found is None or found.opcode != expected.opcode:
        there = "the end of the file" if found is None else _parts(found, topics)[-1].text
        return Divergence(-1, 0, "file", f"record at byte {expected.offset}", there, theirs[-1].text)
    ours = _parts(found, topics)
    for it, wanted in zip_longest(ours, theirs):
        named = it or wanted
        if named is not None and it != wanted:
            texts = ("nothing" if part is None else part.text for part in (it, wanted))
            return Divergence(-1, named.time_ns, named.topic, named.component, *texts)
    raise AssertionError("records that differ have the same parts")


def _parts(record: Record, topics: Mapping[int, str]) -> list[_Part]:
    """Return what a record is made of, for people to see where two part; at its end all of it."""
    name = kind_of(record.opcode)
    whole = _Part("file", f"{name} at byte {record.offset}", f"{name}, {shown(record.body)}", record.body)
    try:
        return [*_inner_parts(record, topics), whole]
    except DAMAGE:
        return [whole]


def _inner_parts(record: Record, topics: Mapping[int, str]) -> Iterator[_Part]:
    where = f"at byte {record.offset}"
    match record.opcode:
        case Opcode.HEADER:
            header = mcap.Header.read(body_stream(record.body))
            yield _Part("file", f"header {where}", f"{brief(header.profile)!r}, {brief(header.library)!r}", record.body)
        case Opcode.METADATA:
            metadata = mcap.Metadata.read(body_stream(record.body))
            yield from (_Part("metadata", brief(key), brief(text), text) for key, text in metadata.metadata.items())
        case Opcode.ATTACHMENT:
            it = mcap.Attachment.read(body_stream(record.body))
            yield _Part("attachment", brief(it.name), f"{brief(it.media_type)}, {shown(it.data)}", record.body)
        case Opcode.CHUNK:
            for opcode, body in inner_records(chunk_bytes(record)):
                yield _in_chunk(opcode, body, where, topics)


def _in_chunk(opcode: int, body: bytes, where: str, topics: Mapping[int, str]) -> _Part:
    if opcode == Opcode.MESSAGE:
        raw = raw_message(body)
        topic = topics.get(raw.channel, f"channel {raw.channel}")
        return _Part(topic, "bytes", f"message {raw.sequence} on {topic}, {shown(raw.data)}", body, raw.log_time_ns)
    name = kind_of(opcode)
    text = f"{name}, {shown(body)}"
    if opcode == Opcode.SCHEMA:
        name = f"schema {brief(mcap.Schema.read(body_stream(body)).name)}"
    elif opcode == Opcode.CHANNEL:
        name = f"channel of {brief(mcap.Channel.read(body_stream(body)).topic)}"
    return _Part("file", f"{name} in the chunk {where}", text, body)
