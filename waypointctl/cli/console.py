"""The one place for rich: where tables and progress for people go."""

from __future__ import annotations

import io
import sys
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rich.console import Console

_PIPE_WIDTH: Final = 120  # columns where there is no terminal to ask, so that tables keep their cells whole


def console(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr, with colours and progress on a terminal only.

    What is printed is taken as it is: names from missions and logs are no markup.
    """
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="replace")  # a name that the terminal cannot show is no reason to end a flight

    def make(width: int | None) -> Console:
        return Console(stderr=stderr, width=width, highlight=False, markup=False, emoji=False)

    made = make(None)
    return made if made.is_terminal else make(_PIPE_WIDTH)


def is_live(people: Console) -> bool:
    """Return whether what has been printed can be drawn over."""
    return people.is_terminal and not people.is_dumb_terminal
