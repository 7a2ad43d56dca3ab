"""Standard output and error for as long as a command runs, and the consoles of rich that print there.

What is printed can be shown, and printing never fails: a reader that goes away, a full disk, a stream that is closed or
not UTF-8, none of these ends a flight. An answer that could not be written, other than to a reader that has gone, is
reported by `DisplayStream.failure`.
"""

from __future__ import annotations

import errno
import io
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import IO, TYPE_CHECKING, Final, TextIO, cast

from waypointctl.display_text import printable_lines

if TYPE_CHECKING:
    from rich.console import Console


class StyledStream(io.TextIOBase):
    """A text stream in front of another that keeps its errors to itself; it passes a terminal's sequences on.

    It has no `buffer`: all that is printed is text, and passes through here.

    Attributes:
        error: why something could not be written, None if all was; from then on everything is dropped.
    """

    _unencodable = "replace"  # as wide as what it stands for, so that tables stay aligned

    def __init__(self, stream: IO[str] | None) -> None:
        """Stand in front of a stream; None for one that was closed before the program began."""
        self._stream = stream
        self._is_terminal = self.isatty()
        self.error: OSError | None = None

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """The stream's encoding."""
        return getattr(self._stream, "encoding", None) or "utf-8"

    @property
    def errors(self) -> str:  # type: ignore[override]
        """How characters that the encoding lacks are written."""
        return self._unencodable

    def isatty(self) -> bool:
        """Return whether a terminal shows it."""
        return self._stream is not None and self._stream.isatty()

    def fileno(self) -> int:
        """Return the stream's file descriptor."""
        if self._stream is None:
            raise io.UnsupportedOperation("fileno")
        return self._stream.fileno()

    def writable(self) -> bool:
        """Return True."""
        return True

    def write(self, text: str) -> int:
        """Write a text, or drop it."""
        if self._stream is None:
            self.error = OSError(errno.EBADF, "the stream is closed")
        elif self.error is None:
            encoding = self.encoding
            try:
                self._stream.write(text.encode(encoding, self._unencodable).decode(encoding))
            except OSError as error:
                self._fail(error)
        return len(text)

    def flush(self) -> None:
        """Hand on what is in the stream's buffer."""
        if self._stream is not None and self.error is None:
            try:
                self._stream.flush()
            except OSError as error:
                self._fail(error)

    def _fail(self, error: OSError) -> None:
        self.error = error
        # The interpreter flushes the stream as it ends, and would report the same error once more.
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)


class DisplayStream(StyledStream):
    """A text stream in front of another: what would steer, break or disorder a terminal's lines is escaped.

    Attributes:
        styled: the same stream for what is to steer the terminal.
    """

    _unencodable = "backslashreplace"

    def __init__(self, stream: IO[str] | None) -> None:
        """Stand in front of a stream; None for one that was closed before the program began."""
        super().__init__(stream)
        self.styled = StyledStream(stream)

    @property
    def failure(self) -> OSError | None:
        """Why something of either kind could not be written; None if all was, or whoever read it has gone."""
        error = self.error or self.styled.error
        if error is None or error.errno == errno.EPIPE or (self._is_terminal and error.errno == errno.EIO):
            return None
        return error

    def write(self, text: str) -> int:
        """Write a text with its line breaks and no other control character."""
        super().write(printable_lines(text))
        return len(text)


def has_failed(stream: IO[str]) -> bool:
    """Return whether nothing that is written to a stream is shown any more, such as when its reader has gone."""
    return isinstance(stream, DisplayStream) and (stream.error or stream.styled.error) is not None


def styled(stream: IO[str]) -> IO[str]:
    """Return what a terminal's own sequences are written to."""
    return cast("IO[str]", stream.styled) if isinstance(stream, DisplayStream) else stream


@contextmanager
def display_streams() -> Iterator[DisplayStream]:
    """Print through display streams in a `with` block; yield standard output."""
    _occupy_descriptors()
    before = sys.stdout, sys.stderr
    out, err = DisplayStream(sys.stdout), DisplayStream(sys.stderr)
    sys.stdout, sys.stderr = cast("TextIO", out), cast("TextIO", err)
    try:
        yield out
    finally:
        for stream in (out, out.styled, err, err.styled):
            stream.flush()
        sys.stdout, sys.stderr = before


def _occupy_descriptors() -> None:
    """Open the null device for each standard stream that is closed: the next file opened would take its place."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free descriptor, which is this one


_PIPE_WIDTH: Final = 160  # columns without a terminal, so that tables keep their cells whole
_MOST_COLUMNS: Final = 10_000
_SIZES: Final = ("COLUMNS", "LINES")


def console(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr, with colours and progress on a terminal only.

    What is printed is taken as it is: names from missions and logs are no markup, and cannot steer the
    terminal.
    """
    from waypointctl.cli.tui.terminal import PrintableConsole

    stream = styled(sys.stderr if stderr else sys.stdout)
    environ = {name: value for name, value in os.environ.items() if name not in _SIZES or _is_size(value)}
    made = PrintableConsole(file=stream, highlight=False, markup=False, emoji=False, _environ=environ)
    if made.is_terminal:
        return made
    width = None if "COLUMNS" in environ else _PIPE_WIDTH
    file = cast("IO[str]", _Trimmed(stream))
    return PrintableConsole(file=file, width=width, highlight=False, markup=False, emoji=False, _environ=environ)


def _is_size(text: str) -> bool:
    """Return whether an environment variable gives the size of the terminal; 0 means unknown."""
    return re.fullmatch("[0-9]{1,5}", text) is not None and 0 < int(text) <= _MOST_COLUMNS


class _Trimmed:
    """A stream that leaves out the spaces at the end of each line: a table pads its cells with them."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        self._stream.write(re.sub(" +$", "", text, flags=re.MULTILINE))
        return len(text)


def is_live(people: Console) -> bool:
    """Return whether what has been printed can be drawn over."""
    return people.is_terminal and not people.is_dumb_terminal
