"""Ctrl-C, SIGTERM and SIGHUP: the first asks a flight to end, the second ends the program.

Outside a flight Ctrl-C ends the program with exit code 130 and no traceback, wherever it is, and SIGTERM and SIGHUP do
what they do to any program: nothing is kept in temporary files that would stay.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType
from typing import Final, TypeAlias

from waypointctl.cli.main import INTERRUPTED

# Of one press of Ctrl-C more than one signal can come: from the terminal, and from a program between it and this one.
_SAME_PRESS_S: Final = 0.2
_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

Handler: TypeAlias = Callable[[int, FrameType | None], None]


class Ending:
    """Whether the program is to end now.

    Attributes:
        is_forced: whether a signal has ended it: whatever comes of that, the exit code is 130.
    """

    is_forced = False


def end_program(number: int, frame: FrameType | None) -> None:
    """End the program from wherever it is, as a signal handler; the second time without any cleaning up."""
    if Ending.is_forced:
        os._exit(INTERRUPTED)
    Ending.is_forced = True
    raise KeyboardInterrupt


@contextmanager
def handled(handler: Handler, signals: tuple[signal.Signals, ...]) -> Iterator[None]:
    """Have signals handled in a `with` block; one that the program was started to ignore stays ignored."""
    wanted = [number for number in signals if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, handler) for number in wanted}
    try:
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)


@contextmanager
def interruption() -> Iterator[Callable[[], bool]]:
    """Yield a function that says whether the end was requested.

    A second signal raises KeyboardInterrupt wherever the program is.
    """
    asked_s: float | None = None

    def ask(number: int, frame: FrameType | None) -> None:
        nonlocal asked_s
        now_s = monotonic()
        if asked_s is None:
            asked_s = now_s
        elif now_s - asked_s > _SAME_PRESS_S:
            end_program(number, frame)

    with handled(ask, _SIGNALS):
        yield lambda: asked_s is not None


@contextmanager
def ending() -> Iterator[None]:
    """Let Ctrl-C end the program in a `with` block; what it breaks on its way is not reported."""
    Ending.is_forced = False
    hook = sys.unraisablehook

    def unraisable(unraisable: sys.UnraisableHookArgs) -> None:
        if not Ending.is_forced:
            hook(unraisable)
        elif issubclass(unraisable.exc_type, KeyboardInterrupt):
            os._exit(INTERRUPTED)  # it was raised where Python drops exceptions, and the program would go on

    sys.unraisablehook = unraisable
    try:
        with handled(end_program, (signal.SIGINT,)):
            yield
    finally:
        sys.unraisablehook = hook
