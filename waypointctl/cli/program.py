"""The one place where the end of a command, and every error, becomes an exit code."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from waypointctl.cli.interruption import Ending, ending
from waypointctl.cli.main import INTERRUPTED
from waypointctl.cli.standard_streams import display_streams
from waypointctl.errors import WaypointctlError

if TYPE_CHECKING:
    from typer import Typer


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
