"""Single keys from the terminal, without waiting for Enter."""

from __future__ import annotations

import os
import select
import sys
import time

from waypointctl.cli.tui.key_by_key import KeyByKey


class Keyboard(KeyByKey):
    """Reads keys in a `with` block; where stdin is no terminal there never is one."""

    def __init__(self) -> None:
        """Look whether there is a terminal; it is left as it is until the block is entered."""
        super().__init__(is_terminal=sys.stdin is not None and sys.stdin.isatty())

    def read(self, timeout_s: float) -> str:
        """Return the next key, or "" if none is pressed within `timeout_s`."""
        if not self.is_terminal:
            time.sleep(timeout_s)
            return ""
        ready, _, _ = select.select([sys.stdin], [], [], timeout_s)
        if not ready:
            return ""
        key = os.read(sys.stdin.fileno(), 1).decode(errors="replace")
        self.is_terminal = bool(key)  # the end of file: the terminal is gone
        return key
