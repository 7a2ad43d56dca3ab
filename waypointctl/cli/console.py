"""The one place for rich: where tables and progress for people go."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rich.console import Console

_PIPE_WIDTH: Final = 120  # columns where there is no terminal to ask, so that tables keep their cells whole


def console(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr, with colours on a terminal only.

    Text is printed as it is: a name with [brackets] in it is no markup.
    """
    from rich.console import Console

    made = Console(stderr=stderr, highlight=False, markup=False)
    if not made.is_terminal:
        made.width = _PIPE_WIDTH
    return made
