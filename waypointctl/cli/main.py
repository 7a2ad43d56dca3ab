"""Where the `waypointctl` program begins. Little is imported before Ctrl-C has its meaning: modules take their time."""

import os
import signal
import sys

INTERRUPTED = 130


def main() -> None:
    """Run the command line and exit.

    While it loads its modules, Ctrl-C ends the program at once with exit code 130; when its work is done it changes
    nothing any more.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, lambda number, frame: os._exit(INTERRUPTED))
    # Else pydantic looks for plugins in the metadata of every package there is, for as long as half of `validate`.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    from waypointctl.cli.program import run_program

    code = run_program()
    # The interpreter takes its handlers away before it ends: another signal of the same kind would be the exit code.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if code == INTERRUPTED else (signal.SIGINT,):
        signal.signal(number, signal.SIG_IGN)
    sys.exit(code)
