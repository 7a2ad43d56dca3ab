"""A terminal that hands over each key as it is pressed, for as long as a `with` block lasts."""

from __future__ import annotations

import sys
import termios
import tty
from contextlib import suppress
from types import TracebackType
from typing import Any, Self


class KeyByKey:
    """The mode of the terminal at stdin; where there is none nothing is changed.

    Attributes:
        is_terminal: whether there is one whose keys are wanted.
    """

    def __init__(self, *, is_terminal: bool) -> None:
        """Leave the terminal as it is until the block is entered."""
        self.is_terminal = is_terminal
        self._before: list[Any] | None = None

    def __enter__(self) -> Self:
        """Have keys delivered one by one, and not echoed."""
        if self.is_terminal:
            self._before = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the terminal as it was."""
        if self._before is not None:
            with suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)
