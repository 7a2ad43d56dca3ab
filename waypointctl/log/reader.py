"""The log reader: a file in, the messages that were written out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from waypointctl.errors import LogError
from waypointctl.log.header import ChunkPlace, LogIndex, TopicSummary
from waypointctl.log.messages import Message, Reward
from waypointctl.log.opening import DAMAGE, OverLimit, damaged, open_file
from waypointctl.log.records import CutShort, RawMessage, Record, chunk_bytes, inner_records, raw_message, records
from waypointctl.log.scan import scan
from waypointctl.log.topics import BY_NAME, Topic
from waypointctl.units import NS_PER_S


def open_log(path: Path, *, allow_truncated: bool = False) -> LogReader:
    """Check the whole file, every checksum of it, and return its reader.

    Args:
        path: the .mcap file, or the .part of a flight that was killed.
        allow_truncated: read a file that is cut short up to where it is whole.

    Raises:
        LogError: the file cannot be read, is damaged or cut short, is over a limit, is not a log of waypointctl or of
            another schema version.
    """
    return LogReader(path, scan(path, allow_truncated=allow_truncated))


class EncodedMessage(NamedTuple):
    """A message of a flight as it stands in the file; a tuple, because it is made for every message of a log."""

    topic: Topic
    raw: RawMessage
    path: str
    offset: int  # of its chunk

    def message(self) -> Message:
        """Return the decoded message.

        Raises:
            LogError: it is not such a message, or its times in the file differ from its own.
        """
        topic, raw = self.topic, self.raw
        try:
            message = topic.decode(raw.data)
        except DAMAGE as error:
            raise damaged(self.path, self.offset, str(error)) from error
        if topic.times_ns(message) != (raw.log_time_ns, raw.publish_time_ns):
            problem = f"a message on {topic.name} has other times in the file than in itself"
            raise damaged(self.path, self.offset, problem)
        return message

    def matches(self, message: Message) -> bool:
        """Tell, without decoding it, whether it is this message as it is written here, to the last bit."""
        topic, raw = self.topic, self.raw
        return (
            type(message) is topic.kind
            and topic.times_ns(message) == (raw.log_time_ns, raw.publish_time_ns)
            and topic.encode(message) == raw.data
        )


@dataclass(frozen=True)
class LogReader:
    """A log that has been found whole, or read up to where it is.

    The file is open only while messages are read, so that nothing has to be closed; a `with` block is allowed.
    """

    path: Path
    index: LogIndex

    def __enter__(self) -> Self:
        """Return the log."""
        return self

    def __exit__(self, *error: object) -> None:
        """Leave the log as it is."""

    @property
    def metadata(self) -> Mapping[str, str]:
        """What the writer said of the flight."""
        return self.index.metadata

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """The files that travel in the log, by name."""
        return self.index.attachments

    @property
    def is_complete(self) -> bool:
        """Whether the file has its end."""
        return self.index.is_complete

    @property
    def topics(self) -> dict[str, TopicSummary]:
        """Every topic, those for viewers too, with how many messages it has and from when to when."""
        return {topic.name: topic for topic in self.index.topics.values()}

    def count(self, topic: str) -> int:
        """Return how many messages there are on a topic, 0 where the log has no such topic."""
        return self.topics[topic].count if topic in self.topics else 0

    @property
    def message_count(self) -> int:
        """How many messages there are, those for viewers too."""
        return sum(topic.count for topic in self.index.topics.values())

    @property
    def start_ns(self) -> int | None:
        """The first log time in [ns], None in a log without messages."""
        return min((chunk.first_ns for chunk in self.index.chunks), default=None)

    @property
    def end_ns(self) -> int | None:
        """The last log time in [ns], None in a log without messages."""
        return max((chunk.last_ns for chunk in self.index.chunks), default=None)

    @property
    def duration_s(self) -> float:
        """From the first log time to the last."""
        return ((self.end_ns or 0) - (self.start_ns or 0)) / NS_PER_S

    def messages(
        self, topics: str | Collection[str] | None = None, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[Message]:
        """Return the messages in the order they were written, equal to those, floats bit for bit.

        Args:
            topics: only these, or this one; all of the flight's own records if None. The topics for viewers hold no
                messages.
            start_ns: only with a log time not before this.
            end_ns: only with a log time before this.

        Raises:
            LogError: a topic that holds no messages; while iterating, data that is not such a message, or one whose
                times in the file differ from its own.
        """
        return self._messages(_decoders(self, topics), start_ns or 0, 1 << 64 if end_ns is None else end_ns)

    def __iter__(self) -> Iterator[Message]:
        """Return all of the flight's messages, in the order they were written."""
        return self.messages()

    def arrays(self, topic: str) -> dict[str, NDArray[Any]]:
        """Return the messages of a topic as columns, such as {"time_ns": (n,), "step": (n,), "qpos": (n, nq)}.

        Numbers and texts are columns (n,), and so is each named term of a reward; arrays of one length are stacked.
        Waypoints, commands and what else has no fixed size is left out: `messages` has it.

        Raises:
            LogError: a topic that holds no messages; a message cannot be read.
        """
        return columns(list(self.messages((topic,))))

    def raw_messages(self) -> Iterator[tuple[str, RawMessage]]:
        """Return every message with its topic, those for viewers too, as it stands in the file."""
        topics = self.index.topics
        for chunk in self._chunks(0, 1 << 64):
            for opcode, body in inner_records(chunk_bytes(chunk)):
                if opcode == Opcode.MESSAGE:
                    raw = raw_message(body)
                    yield topics[raw.channel].name, raw

    def encoded_messages(self) -> Iterator[EncodedMessage]:
        """Return all of the flight's own messages in the order they were written, not yet decoded.

        Raises:
            LogError: while iterating, data that is not a message.
        """
        return self._sealed(_decoders(self, None), 0, 1 << 64)

    def _messages(self, decoders: Mapping[int, Topic], start_ns: int, end_ns: int) -> Iterator[Message]:
        return (sealed.message() for sealed in self._sealed(decoders, start_ns, end_ns))

    def _sealed(self, decoders: Mapping[int, Topic], start_ns: int, end_ns: int) -> Iterator[EncodedMessage]:
        path = str(self.path)
        for chunk in self._chunks(start_ns, end_ns):
            try:
                for opcode, body in inner_records(chunk_bytes(chunk)):
                    if opcode != Opcode.MESSAGE:
                        continue
                    raw = raw_message(body)
                    topic = decoders.get(raw.channel)
                    if topic is not None and start_ns <= raw.log_time_ns < end_ns:
                        yield EncodedMessage(topic, raw, path, chunk.offset)
            except DAMAGE as error:
                raise damaged(path, chunk.offset, str(error)) from error

    def _chunks(self, start_ns: int, end_ns: int) -> Iterator[Record]:
        def wanted(place: ChunkPlace) -> bool:
            return place.last_ns >= start_ns and place.first_ns < end_ns

        with open_file(self.path) as stream:
            for place in filter(wanted, self.index.chunks):
                try:
                    yield next(records(stream, place.offset, self.index.size_bytes))
                except (CutShort, OverLimit, StopIteration):
                    raise damaged(str(self.path), place.offset, "it was changed while it was read") from None


def _decoders(log: LogReader, names: str | Collection[str] | None) -> dict[int, Topic]:
    wanted = BY_NAME.keys() if names is None else (names,) if isinstance(names, str) else names
    for name in wanted:
        if name not in BY_NAME:
            raise LogError(f"no messages are read from the topic {name!r}; allowed are {', '.join(BY_NAME)}")
    topics = log.index.topics.items()
    return {channel: BY_NAME[topic.name] for channel, topic in topics if topic.name in wanted}


Column = NDArray[Any]


def columns(messages: Sequence[Message]) -> dict[str, Column]:
    """Return each field of messages of one kind as an array, the message along the first axis.

    Numbers and texts are (n,); arrays that have the same shape in every message are stacked, (n, k); the terms of
    rewards are columns of their own. Fields without a fixed size, such as the waypoints of a command, are left out.
    """
    if not messages:
        return {}
    found = {}
    for field in fields(messages[0]):
        column = _column([getattr(message, field.name) for message in messages])
        if column is not None:
            found[field.name] = column
    rewards = [dict(message.terms) for message in messages if isinstance(message, Reward)]
    for name in dict.fromkeys(name for terms in rewards for name in terms):
        found[name] = np.array([terms.get(name, np.nan) for terms in rewards])
    return found


def _column(values: list[Any]) -> Column | None:
    first = values[0]
    if isinstance(first, np.ndarray):
        return np.stack(values) if all(value.shape == first.shape for value in values) else None
    if isinstance(first, str):
        return np.array([str(value) for value in values])
    return np.array(values) if isinstance(first, int | float) else None
