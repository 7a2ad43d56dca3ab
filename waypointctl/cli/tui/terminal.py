"""The terminal: a console that text from files cannot steer, pictures drawn over each other, and what is typed."""

from __future__ import annotations

import os
import select
import sys
import termios
import time
import tty
from abc import ABC, abstractmethod
from collections.abc import Iterable
from contextlib import suppress
from types import TracebackType
from typing import Any, Final, Self

from rich.console import Console, ConsoleOptions, RenderableType
from rich.live import Live
from rich.rule import Rule
from rich.segment import Segment

from waypointctl.display_text import printable_lines
from waypointctl.errors import InputError


class PrintableConsole(Console):
    """A rich console whose text has no control characters but line breaks; rich's own sequences stay."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Yield what a thing is printed as."""
        for segment in super().render(renderable, options):
            if segment.control or (shown := printable_lines(segment.text)) == segment.text:
                yield segment
            else:
                yield Segment(shown, segment.style)


class Screen(ABC):
    """Draws pictures on a terminal, each over the one before; use it in a `with` block."""

    def __init__(self, people: Console, period_s: float) -> None:
        """Draw on `people`, a terminal, if it is asked to, and no more often than this of itself."""
        self._console, self._period_s, self._next_s = people, period_s, 0.0
        self._ascii_only = not people.encoding.lower().startswith("utf")
        self._live = Live(console=people, auto_refresh=False, redirect_stdout=False, redirect_stderr=False)

    def __enter__(self) -> Self:
        """Begin to draw."""
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the last picture standing."""
        self.draw()
        self._live.stop()

    @abstractmethod
    def picture(self) -> RenderableType:
        """Return what is drawn, made to the terminal's size as it is now."""

    def draw(self) -> None:
        """Draw now."""
        self._live.update(self.picture(), refresh=True)
        self._next_s = time.monotonic() + self._period_s

    def draw_if_due(self) -> None:
        """Draw if it is time for another picture."""
        if time.monotonic() >= self._next_s:
            self.draw()

    def rule(self) -> Rule:
        """Return a line across the terminal."""
        return Rule(style="dim", characters="-" if self._ascii_only else "─")


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


class Keyboard(KeyByKey):
    """Reads keys in a `with` block; without a terminal as stdin there are none."""

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


MOST_COLUMNS: Final = 200  # of a line: no command is as long
_AT_ONCE: Final = 4096  # bytes read in one go
_ESCAPE: Final = "\x1b"
_UP: Final = f"{_ESCAPE}[A"
_END: Final = "\x04"  # Ctrl-D
_CLEAR: Final = "\x15"  # Ctrl-U
_BACK: Final = ("\x7f", "\b")


class TypedLines(KeyByKey):
    """Reads lines in a `with` block. The lines of a pipe or a file are read as fast as they come.

    Attributes:
        is_open: whether more may come.
        is_terminal: whether somebody types them: then what is typed is not echoed, but is in `draft`.
        draft: what has been typed of the line to come.
    """

    def __init__(self, *, echo: bool) -> None:
        """Look at stdin; without `echo` there is nowhere to show a draft, and a terminal shows it by itself."""
        if sys.stdin is None:
            raise InputError("--console: there is no stdin to read commands from")
        super().__init__(is_terminal=echo and sys.stdin.isatty())
        self.is_open = True
        self.draft = ""
        self._last = ""
        self._escape = ""  # a key of several characters, as far as it has come

    def read(self, timeout_s: float) -> list[str]:
        """Return the lines that are ready, if need be after waiting for `timeout_s` for something to be typed."""
        if not self.is_open:
            time.sleep(timeout_s)
            return []
        ready, _, _ = select.select([sys.stdin], [], [], timeout_s)
        if not ready:
            return []
        try:
            typed = os.read(sys.stdin.fileno(), _AT_ONCE).decode(errors="replace")
        except OSError:  # the terminal is gone
            typed = ""
        if not typed:
            return self._end()
        return [line for key in typed if (line := self._take(key)) is not None]

    def _take(self, key: str) -> str | None:
        """Take one character; return the line that it ends."""
        if not self.is_open:
            return None
        if self.is_terminal and (self._escape or key == _ESCAPE):
            self._take_escape(key)
        elif key in "\r\n":
            return self._line()
        elif self.is_terminal and key in _BACK:
            self.draft = self.draft[:-1]
        elif self.is_terminal and key == _CLEAR:
            self.draft = ""
        elif self.is_terminal and key == _END and not self.draft:
            self.is_open = False
        elif (key.isprintable() or key == "\t") and len(self.draft) < MOST_COLUMNS:
            self.draft += key
        return None

    def _take_escape(self, key: str) -> None:
        """Take a character of an arrow key or the like; up brings back the last line."""
        self._escape += key
        if self._escape == _UP:
            self.draft = self._last
        if len(self._escape) > 1 and key not in "[O0123456789;":
            self._escape = ""

    def _line(self) -> str:
        line, self.draft = self.draft.strip(), ""
        self._last = line or self._last
        return line

    def _end(self) -> list[str]:
        self.is_open = False
        return [self._line()] if self.draft else []
