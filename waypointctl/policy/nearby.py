"""Nearby policies, for the message about a folder that is not a policy."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Final

from waypointctl.mission.policy_name import policies_there_are
from waypointctl.policy.manifest import MANIFEST

_NAMED: Final = 3  # policies in a message
_LOOKED_AT: Final = 2000  # folders: the named folder may be a whole disk


def policies_near(folder: Path) -> str:
    """Return which folders in a folder, or in the folders in it, are policies, the newest first, as a hint."""
    for found in (_policies(folders) for folders in (_folders(folder), _folders_in_folders(folder))):
        if found:
            more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
            names = ", ".join(str(path) for path in found[:_NAMED])
            return (
                f"Policies in it are {names}{more}: give one of these." if len(found) > 1 else f"Did you mean {names}?"
            )
    return policies_there_are()


def _policies(folders: Iterator[Path]) -> list[Path]:
    dated = []
    for folder in islice(folders, _LOOKED_AT):
        try:
            dated.append((-(folder / MANIFEST).stat().st_mtime_ns, folder))
        except OSError:
            continue
    return [folder for _, folder in sorted(dated)]


def _folders(folder: Path) -> Iterator[Path]:
    """Yield the folders in a folder; without unreadable and hidden ones."""
    try:
        yield from (path for path in folder.iterdir() if not path.name.startswith(".") and path.is_dir())
    except OSError:
        return


def _folders_in_folders(folder: Path) -> Iterator[Path]:
    for inner in _folders(folder):
        yield from _folders(inner)
