"""The file of a log as a whole: what a comparison of the flight's messages cannot see."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO

from waypointctl.log.audit import audit
from waypointctl.log.channels import ChannelWriter
from waypointctl.log.comparison import Diverged, FileComparison
from waypointctl.log.messages import Message
from waypointctl.log.opening import open_file
from waypointctl.log.reader import LogReader
from waypointctl.log.same_records import compare_readers, compare_records
from waypointctl.log.writer import LogEncoder
from waypointctl.replay.contents import LogContents, platform_differences


@contextmanager
def whole_file(log: LogReader, contents: LogContents) -> Iterator[WholeFile]:
    """Open the file of a log for the time of its comparison.

    Raises:
        Diverged: what stands before the first message differs.
    """
    with open_file(log.path) as stream:
        yield WholeFile(log, contents, stream)


class WholeFile:
    """Writes a log anew, and compares it with the file.

    What the log names as the program and processor that wrote it is written as it stands there, so that all else is
    compared on every program.

    Attributes:
        checks: what was compared, a line each.
        not_compared: what was not, and why, a line each.
    """

    def __init__(self, log: LogReader, contents: LogContents, stream: IO[bytes]) -> None:
        """Compare `log`, whose file is open at its start, with what is written of a flight of what it carries."""
        self.checks: tuple[str, ...] = ()
        others = ", ".join(platform_differences(log))
        self.not_compared: tuple[str, ...] = (
            (f"the program and processor named in the log: {others}",) if others else ()
        )
        self._comparison = FileComparison(stream, os.fstat(stream.fileno()).st_size)
        self._log = log
        self._header = contents.header_as_in(log)
        self._writer = ChannelWriter(self._comparison, self._header.library)
        self._encoder = LogEncoder(self._writer, self._header)
        self._require_equal()

    def __call__(self, message: Message) -> None:
        """Write a message of the flight, as it is in the log.

        Raises:
            Diverged: the file differs before it.
        """
        self._encoder(message)
        self._require_equal()

    def finish(self) -> None:
        """Write the end; where another program wrote the file, compare its records if its bytes differ.

        Raises:
            Diverged: the file differs.
        """
        self._encoder.finish()
        if self._comparison.difference(self._writer.topics) is None:
            size = f"{self._comparison.compared:,} bytes"
            self.checks = (f"the whole file, rewritten and compared byte for byte: {size}",)
            return
        if not self.not_compared:
            self._raise()
        audit(self._log)
        count = compare_records(self._log, self._header)
        compare_readers(self._log)
        self.checks = (
            f"{count} records of the file, and the messages that mcap's streaming and seeking readers return",
        )
        self.not_compared += ("the bytes of the file: its records are chunked or compressed differently",)

    def _require_equal(self) -> None:
        """Raise Diverged where the program that is here should have written other bytes."""
        if self._comparison.differs and not self.not_compared:
            self._raise()

    def _raise(self) -> None:
        difference = self._comparison.difference(self._writer.topics)
        if difference is not None:
            raise Diverged(difference)
