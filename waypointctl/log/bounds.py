"""How much of a log is read: everything is counted before memory is taken for it (docs/limits.md).

A few kilobytes of a compressed file can unpack to gigabytes. So what unpacking gives is bounded by the size of the
file: a log of a flight of days is large, and may unpack to as much more.
"""

from __future__ import annotations

from typing import Final

from waypointctl.errors import LogError
from waypointctl.limits import LIMITS, limit, limit_hint

FREE_BYTES: Final = 2**26  # that all chunks together may unpack to, whatever the file's size
_LEAST_ATTACHMENT: Final = 45  # [bytes] of an attachment's record without its name and content
_LEAST_ENTRY: Final = 4  # [bytes] of an entry: the length of its name
INDEX_BYTES: Final = 16  # in the file for each message: its entry in the index of its chunk


class OverLimit(ValueError):
    """There is more of something than is read."""

    def __init__(self, name: str, what: str, found: int, enough: int = 0) -> None:
        """Say of what there are `found`, or more, but at most `enough` if it is given; and which limit that is over."""
        super().__init__(f"has at least {found:,} {what}; the limit {name} is {LIMITS[name].text(limit(name))}")
        self._hint = limit_hint(name, max(found, enough))

    def refusal(self, path: str) -> LogError:
        """Return the error for the log at `path`."""
        return LogError(str(self), where=path, hint=self._hint)


class Bounds:
    """Counts what is read of one log.

    Raises:
        OverLimit: in each `take_...`: there is more than the limit.
    """

    def __init__(self, file_bytes: int) -> None:
        """Begin with a file of this size, of which nothing has been read."""
        self._file_bytes = file_bytes
        self._attachments = self._attached = self._entries = self._described = self._unpacked = self._messages = 0

    def take_attachment(self, size: int) -> None:
        """Count an attachment of this many bytes."""
        self._attachments += 1
        self._attached += size
        _require("log-entries", self._attachments, "attachments", self._file_bytes // _LEAST_ATTACHMENT)
        _require("log-attachments", self._attached, "bytes of attachments", self._file_bytes)

    def take_description(self, size: int) -> None:
        """Count a metadata record, a schema or a channel of this many bytes."""
        self._described += size
        enough = max(self._file_bytes, self._unpacked)
        _require("log-metadata", self._described, "bytes of metadata, schemas and channels", enough)

    def take_entries(self, count: int) -> None:
        """Count entries of metadata, schemas or channels."""
        self._entries += count
        enough = max(self._file_bytes, self._unpacked) // _LEAST_ENTRY
        _require("log-entries", self._entries, "entries of metadata, schemas and channels", enough)

    def take_chunk(self, unpacked: int) -> None:
        """Count a chunk that declares to unpack to this many bytes."""
        _require("log-chunk", unpacked, "bytes in one chunk")
        self._unpacked += unpacked
        beyond = max(0, self._unpacked - FREE_BYTES)
        _require("log-expansion", -(-beyond // self._file_bytes), "times as many bytes in chunks as in the file")

    def take_messages(self, count: int) -> None:
        """Count messages."""
        self._messages += count
        beyond = self._messages - self._file_bytes // INDEX_BYTES
        _require("log-messages", beyond, "messages more than its file has room for an index of")


def _require(name: str, found: int, what: str, enough: int = 0) -> None:
    if found > limit(name):
        raise OverLimit(name, what, found, enough)
