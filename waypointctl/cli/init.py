"""`waypointctl init`: a mission, a suite and a recipe to start from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Final

import typer

from waypointctl.display_text import shell_word
from waypointctl.errors import OutputError
from waypointctl.mission.policy_name import FLAGSHIP
from waypointctl.paths import refuse_unwritable_folder, write_whole

MISSION: Final = "mission.yaml"
SUITE: Final = "suite.yaml"
RECIPE: Final = "recipe.yaml"


def init(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder; made if it is missing.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
) -> None:
    """Write a mission, a suite and a training recipe to start from.

    The files have comments and go into a folder.

    A file that is already there is never replaced.
    """
    starter = files("waypointctl.cli") / "starter"
    contents = {folder / name: (starter / name).read_bytes() for name in (MISSION, SUITE, RECIPE)}
    _refuse_existing(contents)
    _write(contents, folder)
    for line in _lines(folder):
        typer.echo(line, err=as_json)
    if as_json:
        typer.echo(json.dumps({"folder": str(folder), "files": [str(path) for path in contents]}, indent=2))


def _refuse_existing(contents: Mapping[Path, bytes]) -> None:
    try:
        existing = [str(path) for path in contents if path.exists() or path.is_symlink()]
    except OSError:
        return  # such as a name that is too long: the folder cannot be made either, which is reported next
    if existing:
        verb = "is" if len(existing) == 1 else "are"
        problem = f"{', '.join(existing)} {verb} already there; nothing was written"
        raise OutputError(problem, hint="Give another folder, or move what is there.")


def _write(contents: Mapping[Path, bytes], folder: Path) -> None:
    refuse_unwritable_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder cannot be made: {error.strerror}", where=str(folder)) from error
    written: list[Path] = []
    try:
        for path, content in contents.items():
            write_whole(path, content, "the file")
            written.append(path)
    except OutputError:
        for path in written:  # all of them or none
            path.unlink(missing_ok=True)
        raise


def _lines(folder: Path) -> list[str]:
    """Return what was written and what to do with it."""
    mission, suite, recipe = (shell_word(folder / name) for name in (MISSION, SUITE, RECIPE))
    return [
        f"{mission}: a mission of two waypoints",
        f"{suite}: an evaluation suite",
        f"{recipe}: a training recipe",
        "",
        "Next:",
        f"  waypointctl validate {mission}",
        f"  waypointctl run {mission}",
        f"  waypointctl eval {FLAGSHIP} --suite {suite}",
        f"  waypointctl train {recipe}",
    ]
