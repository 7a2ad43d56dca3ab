"""Where the lines of a console come from: a terminal, a script, a log."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Protocol

QUIT: Final = "quit"  # the line that ends it


class LineSource(Protocol):
    """What a flight asks for the lines that a person types while it is under way.

    Lines are taken at moments of the flight, once in each turn of its loop. While physics sleeps a turn may take
    minutes of simulation time, so the source is asked how far time may jump.

    Attributes:
        is_open: whether somebody is there at mission start. Then the flight does not end before a line is QUIT.
    """

    is_open: bool

    def lines(self, now_ns: int) -> Iterable[str]:
        """Yield what has been typed by now and was not yet yielded: what `order_from` understands, or QUIT.

        The next one is asked for when the one before has been obeyed. A source that keeps to wall time waits here.
        """

    def asleep(self, now_ns: int, until_ns: int) -> int:
        """Return when there is something to take, if that is before `until_ns`, or else that; both [ns].

        Between now and then nothing happens on the ground, on board or on the link.
        """


class Nobody:
    """The console of a flight that has none.

    Attributes:
        is_open: never.
    """

    is_open = False

    def lines(self, now_ns: int) -> Iterable[str]:
        """Yield nothing."""
        return ()

    def asleep(self, now_ns: int, until_ns: int) -> int:
        """Let time jump."""
        return until_ns
