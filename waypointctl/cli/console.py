"""The one place for rich: where tables and progress for people go."""

from __future__ import annotations

import io
import os
import re
import sys
from typing import IO, TYPE_CHECKING, Final, cast

if TYPE_CHECKING:
    from rich.console import Console

_PIPE_WIDTH: Final = 160  # columns where there is no terminal to ask, so that tables keep their cells whole


def console(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr, with colours and progress on a terminal only.

    What is printed is taken as it is: names from missions and logs are no markup.
    """
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="replace")  # a name that the terminal cannot show is no reason to end a flight

    made = Console(stderr=stderr, highlight=False, markup=False, emoji=False)
    if made.is_terminal:
        return made
    width = None if os.environ.get("COLUMNS", "").isdigit() else _PIPE_WIDTH
    file = cast("IO[str]", _Trimmed(stream))
    return Console(file=file, width=width, highlight=False, markup=False, emoji=False)


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
