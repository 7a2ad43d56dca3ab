"""What a log holds, as records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mcap.records import Channel, Schema

from waypointctl.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class TopicSummary:
    """What stands on one topic; times are log times in [ns], None where there is no message."""

    name: str
    schema: str
    count: int
    first_ns: int | None
    last_ns: int | None

    @property
    def rate_hz(self) -> float | None:
        """Messages a second between the first and the last, None for fewer than two moments."""
        if self.first_ns is None or self.last_ns is None or self.first_ns == self.last_ns:
            return None
        return (self.count - 1) * NS_PER_S / (self.last_ns - self.first_ns)


@dataclass(frozen=True, slots=True)
class ChunkPlace:
    """Where a chunk is, and the log times in it."""

    offset: int
    first_ns: int
    last_ns: int


@dataclass(frozen=True, slots=True)
class LogIndex:
    """What a log holds."""

    library: str  # that wrote it
    metadata: Mapping[str, str]
    attachments: Mapping[str, bytes]
    media_types: Mapping[str, str]  # of the attachments
    schemas: Mapping[int, Schema]
    channels: Mapping[int, Channel]
    topics: Mapping[int, TopicSummary]  # by channel
    chunks: tuple[ChunkPlace, ...]
    size_bytes: int
    is_complete: bool
