"""Single keys from the terminal, without waiting for Enter."""

from __future__ import annotations

import os
import select
import sys
import termios
import time
import tty
from types import TracebackType
from typing import Any, Self


class Keyboard:
    """Reads keys in a `with` block; where stdin is no terminal there never is one."""

    def __init__(self) -> None:
        """Look whether there is a terminal; it is left as it is until the block is entered."""
        self.is_there = sys.stdin is not None and sys.stdin.isatty()
        self._before: list[Any] | None = None

    def __enter__(self) -> Self:
        """Have keys delivered one by one, and not echoed."""
        if self.is_there:
            self._before = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the terminal as it was."""
        if self._before is not None:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)

    def read(self, timeout_s: float) -> str:
        """Return the next key, or "" if none is pressed within `timeout_s`."""
        if not self.is_there:
            time.sleep(timeout_s)
            return ""
        ready, _, _ = select.select([sys.stdin], [], [], timeout_s)
        if not ready:
            return ""
        key = os.read(sys.stdin.fileno(), 1).decode(errors="replace")
        self.is_there = bool(key)  # the end of file: the terminal is gone
        return key
