"""The log writer: a sink that a flight's messages go into."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from waypointctl.errors import OutputError
from waypointctl.log.channels import ChannelWriter
from waypointctl.log.encoder import LogEncoder
from waypointctl.log.header import LogHeader
from waypointctl.log.messages import Message
from waypointctl.paths import lock


class LogWriter:
    """Writes messages to `path`: call it with each, then close it.

    Messages wait for the end of their simulated second, when they are encoded and handed to the operating system
    together: a process that is killed would lose them either way, and between the steps of a simulation each would
    take twice as long. No wall clock is asked, so the bytes depend on the messages alone.

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
        raise OutputError(f"cannot be written: {error.strerror}", where=str(path), hint=hint) from error
