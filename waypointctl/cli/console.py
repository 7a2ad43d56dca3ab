"""The one place for rich: where tables and progress for people go."""

from __future__ import annotations

import os
import re
import sys
from typing import IO, TYPE_CHECKING, Final, cast

from waypointctl.cli.standard_streams import styled

if TYPE_CHECKING:
    from rich.console import Console

_PIPE_WIDTH: Final = 160  # columns without a terminal, so that tables keep their cells whole
_MOST_COLUMNS: Final = 10_000
_SIZES: Final = ("COLUMNS", "LINES")


def console(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr, with colours and progress on a terminal only.

    What is printed is taken as it is: names from missions and logs are no markup, and cannot steer the
    terminal.
    """
    from waypointctl.cli.tui.printable_console import PrintableConsole

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
