"""How the program ends: every error and every signal becomes an exit code.

Of Ctrl-C, SIGTERM and SIGHUP the first asks a flight to end, the second ends the program. Outside a flight Ctrl-C ends
the program with exit code 130 and no traceback, wherever it is, and SIGTERM and SIGHUP do what they do to any program:
nothing is kept in temporary files that would stay.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType
from typing import TYPE_CHECKING, Final, TypeAlias

from waypointctl.cli.console import display_streams
from waypointctl.cli.main import INTERRUPTED
from waypointctl.errors import WaypointctlError

if TYPE_CHECKING:
    from typer import Typer


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


def run_program() -> int | str | None:
    """Run the command line; print what waypointctl refuses as one message and return what to exit with.

    Under --json the message stands on stdout too, as an object: a program that reads one has one in any case. A reader
    that goes away changes neither what is done nor the exit code; an answer that cannot be written is exit code 2,
    unless the command was interrupted.
    """
    from waypointctl.cli.app import app  # before Ctrl-C raises: what is raised in an import may be caught there

    with display_streams() as out, ending():
        try:
            code = _run(app)
        except BaseException:
            if not Ending.is_forced:
                raise
            code = INTERRUPTED
        out.flush()
        if out.failure is not None:
            print(f"error: the answer cannot be written: {out.failure.strerror}", file=sys.stderr)
            code = code if code == INTERRUPTED else 2
    return INTERRUPTED if Ending.is_forced else code


def _run(app: Typer) -> int | str | None:
    """Run the command; return what to exit with."""
    try:
        app()
    except SystemExit as end:
        return end.code
    except WaypointctlError as error:
        if Ending.is_forced:
            return INTERRUPTED
        print(f"error: {error}", file=sys.stderr)
        if "--json" in sys.argv[1:]:
            _print_refusal(error)
        return error.exit_code
    return 0


def _print_refusal(error: WaypointctlError) -> None:
    import json

    parts = {name: getattr(error, name, None) for name in ("problem", "where", "hint")}
    lines = [parts["problem"] or str(error), *getattr(error, "details", ())]
    print(json.dumps({"error": parts | {"problem": "\n".join(lines)}, "exit_code": error.exit_code}))
