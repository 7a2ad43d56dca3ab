"""The log writer: a flight's messages as the records of its log, and the file that they go into."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO, Final, Protocol, Self

from google.protobuf.message import Message as ProtobufMessage

from waypointctl.errors import OutputError
from waypointctl.log.channels import ChannelWriter
from waypointctl.log.chunk import Channel
from waypointctl.log.foxglove.view import VIEW_TOPICS, FoxgloveView, Frame, layout
from waypointctl.log.header import LAYOUT_NAME, METADATA_NAME, SCHEMA_VERSION, Attachment, LogHeader
from waypointctl.log.messages import Message
from waypointctl.log.topics import BY_KIND, ON_DEMAND, TOPICS
from waypointctl.paths import lock, write_fault
from waypointctl.units import NS_PER_S


class LogWriter:
    """Writes messages to `path`: call it with each, then close it.

    Messages wait for the end of their simulated second, when they are encoded and handed to the operating system
    together: a process that is killed would lose them either way, and between the steps of a simulation each would
    take twice as long. No wall clock is read, so the bytes depend on the messages alone.

    Until it is closed the log stands at `<path>.part`, whole up to the last simulated second even if the process is
    killed. close() gives it its name. An exception that leaves the `with` block closes the file too, so that it can
    be read, but leaves it at `<path>.part`: what stands at `path` is the log of a flight that came to its end.

    Attributes:
        path: of the log.
        part: where it stands until it is closed.

    Raises:
        OutputError: `path` cannot be written, at the beginning or, when the disk is full, on the way.
    """

    def __init__(self, path: Path, header: LogHeader, *, part: Path | None = None) -> None:
        """Create the file and write all that stands before the first message.

        Args:
            path: of the log.
            header: what stands before the messages.
            part: where the log stands until it takes its place, if another log is at `<path>.part` until then.
        """
        self.path = path
        self._place = path.with_name(f"{path.name}.part")
        self.part = part or self._place
        self._stream = _create(path, self.part)
        lock(self._stream)  # so that nobody takes it for the log of a flight that was killed
        try:
            self._encoder = LogEncoder(ChannelWriter(self._stream, header.library), header)
        except BaseException as error:
            with suppress(OSError):  # closing tries to write again
                self._stream.close()
            if isinstance(error, OSError):
                raise self._refusal(error) from error
            raise

    @property
    def flushes(self) -> int:
        """How often all messages before the newest have been handed to the operating system."""
        return self._encoder.flushes

    def __call__(self, message: Message) -> None:
        """Write one message, and what viewers are shown of it."""
        try:
            self._encoder(message)
        except OSError as error:
            raise self._refusal(error) from error

    def close(self) -> None:
        """Write the end of the file and give it its name; closing twice is closing once."""
        if not self._stream.closed:
            self._finish()
            self.take_place()
            os.replace(self.part, self.path)

    def take_place(self) -> None:
        """Stand at `<path>.part` from now on, in the place of what stood there."""
        if self.part != self._place:
            os.replace(self.part, self._place)
            self.part = self._place

    def __enter__(self) -> Self:
        """Return the sink."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close the log; after an exception it keeps its .part name."""
        if kind is None:
            self.close()
        elif not self._stream.closed:
            self._finish()

    def _finish(self) -> None:
        try:
            with self._stream:
                self._encoder.finish()
        except OSError as error:
            raise self._refusal(error) from error

    def _refusal(self, error: OSError) -> OutputError:
        with suppress(OSError):
            if self.part.stat().st_size:
                hint = f"What was written so far is in {self.part}."
                return OutputError(f"cannot be written: {error.strerror}", where=str(self.path), hint=hint)
        hint = "Make room on the disk, or choose another place."
        return OutputError(f"cannot be written: {error.strerror}", where=str(self.path), hint=hint)


def _create(path: Path, part: Path) -> IO[bytes]:
    if path.is_dir():
        raise OutputError("is a folder; a log is a file", where=str(path), hint="Name the file, such as flight.mcap.")
    try:
        return open(part, "wb")
    except OSError as error:
        hint = "Create the folder, or choose another place." if isinstance(error, FileNotFoundError) else None
        raise OutputError(f"cannot be written: {write_fault(path, error)}", where=str(path), hint=hint) from error


SCHEMAS: Final = {topic.name: topic.schema for topic in TOPICS} | VIEW_TOPICS


class RecordSink(Protocol):
    """Takes the records of a log in their order; `ChannelWriter` makes a file of them."""

    def attach(self, attachment: Attachment) -> None:
        """Take an attachment."""

    def describe(self, name: str, metadata: Mapping[str, str]) -> None:
        """Take a metadata record."""

    def open(self, topic: str, schema: type[ProtobufMessage]) -> Channel:
        """Announce a topic; return what its messages are written to."""

    def write(self, channel: Channel, log_time_ns: int, publish_time_ns: int, data: bytes) -> None:
        """Take a message of an open channel."""

    def flush(self) -> None:
        """End a chunk."""

    def finish(self) -> None:
        """End the file."""


class LogEncoder:
    """Encodes messages into records: call it with each, then finish it.

    Messages wait for the end of their simulated second and are encoded together. No wall clock is read, so the
    records depend on the messages alone.

    Attributes:
        flushes: how often all messages before the newest have been handed on.
    """

    def __init__(self, records: RecordSink, header: LogHeader) -> None:
        """Hand on all that stands before the first message."""
        self.flushes = 0
        self._records = records
        self._view = FoxgloveView(header.kinematics, header.waypoints, header.setting)
        self._waiting: deque[Message] = deque()
        self._second_ends_ns = NS_PER_S
        observes = any(waypoint.task for waypoint in header.waypoints)
        view = layout(header.kinematics.body_names[0], camera=observes)
        for attachment in (*header.attachments, Attachment(LAYOUT_NAME, "application/json", view)):
            records.attach(attachment)
        own = {"schema_version": str(SCHEMA_VERSION), "robot": header.robot}
        records.describe(METADATA_NAME, own | dict(header.metadata) | own)
        on_demand = {BY_KIND[kind].name for kind in ON_DEMAND}
        self._channels = {name: records.open(name, SCHEMAS[name]) for name in SCHEMAS if name not in on_demand}
        for frame in self._view.start():
            self._show(frame)
        records.flush()

    def __call__(self, message: Message) -> None:
        """Encode one message, and what viewers are shown of it."""
        log_time_ns, _ = BY_KIND[type(message)].times_ns(message)
        if log_time_ns >= self._second_ends_ns:
            self._second_ends_ns = (log_time_ns // NS_PER_S + 1) * NS_PER_S
            self._encode_waiting()
            self._records.flush()
            self.flushes += 1
        self._waiting.append(message)

    def finish(self) -> None:
        """Encode what waits, and end the file."""
        self._encode_waiting()
        self._records.finish()

    def _encode_waiting(self) -> None:
        # One by one out of the queue: what interrupts this leaves nothing to be written twice.
        while self._waiting:
            message = self._waiting.popleft()
            topic = BY_KIND[type(message)]
            log_time_ns, publish_time_ns = topic.times_ns(message)
            if topic.name not in self._channels:
                self._channels[topic.name] = self._records.open(topic.name, topic.schema)
            self._records.write(self._channels[topic.name], log_time_ns, publish_time_ns, topic.encode(message))
            for frame in self._view(message):
                self._show(frame)

    def _show(self, frame: Frame) -> None:
        self._records.write(self._channels[frame.topic], frame.time_ns, frame.time_ns, frame.data)
