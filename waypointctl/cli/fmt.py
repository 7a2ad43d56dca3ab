"""`waypointctl fmt`: format mission files."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from waypointctl.display_text import printable
from waypointctl.errors import MissionError


def fmt(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION.yaml...", help="Mission files.")],
    check: Annotated[bool, typer.Option("--check", help="Change nothing; exit with 1 if a file would change.")] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Change nothing; print what would.")] = False,
) -> None:
    """Format mission files: keys in order, two spaces a level.

    Comments, quotes and units stay as written.

    A file with errors is not changed; its errors are printed, and the exit code is 2.
    """
    from waypointctl.mission.format import MAX_BYTES, formatted
    from waypointctl.mission.yaml_source import read_source
    from waypointctl.paths import command_for_plan

    changed, wrong = 0, 0
    for path in missions:
        try:
            source = read_source(path, MissionError, MAX_BYTES)
            if plan := command_for_plan(str(path)):
                raise MissionError(plan, where=str(path))
            written = formatted(source, str(path))
        except MissionError as error:
            wrong += 1
            typer.echo(str(error), err=True)
            continue
        if written == source:
            continue
        changed += 1
        if diff:
            sys.stdout.write(_difference(source, written, path))
        if not check and not diff:
            _replace(path, written)
        elif not diff:
            typer.echo(f"{printable(path)}: would be reformatted")
    typer.echo(_summary(len(missions), changed, wrong, check or diff), err=True)
    if wrong:
        raise typer.Exit(2)
    if check and changed:
        raise typer.Exit(1)


def _replace(path: Path, written: bytes) -> None:
    from waypointctl.paths import write_whole

    write_whole(path.resolve(), written, "the mission")  # a link stays one
    typer.echo(f"{printable(path)}: reformatted")


def _difference(source: bytes, written: bytes, path: Path) -> str:
    import difflib

    before, after = (text.decode("utf-8-sig").splitlines(keepends=True) for text in (source, written))
    name = printable(path)
    return "".join(difflib.unified_diff(before, after, name, f"{name} (formatted)"))


def _summary(count: int, changed: int, wrong: int, dry_run: bool) -> str:
    verb = "would change" if dry_run else "changed"
    parts = [f"{changed} {verb}", f"{count - changed - wrong} already formatted"]
    if wrong:
        parts.append(f"{wrong} not changed, with errors")
    return f"{count} mission{'s' if count > 1 else ''}: {', '.join(parts)}"
