"""A flight's messages as the records of its log: what viewers are shown is added, each simulated second is flushed."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Final, Protocol

from google.protobuf.message import Message as ProtobufMessage

from waypointctl.log.chunk import Channel
from waypointctl.log.foxglove.layout import layout
from waypointctl.log.foxglove.view import VIEW_TOPICS, FoxgloveView, Frame
from waypointctl.log.header import LAYOUT_NAME, METADATA_NAME, SCHEMA_VERSION, Attachment, LogHeader
from waypointctl.log.messages import Message
from waypointctl.log.topics import BY_KIND, ON_DEMAND, TOPICS
from waypointctl.units import NS_PER_S

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
