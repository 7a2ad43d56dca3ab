"""The folder that a policy's name or path refers to, in a mission, a recipe or on the command line.

A path is taken as it is, relative to the file that has it. A bare name, such as `ant-waypoint`, is looked for in three
places, and the first that holds a policy is taken:

    NAME                a folder beside the file that has the name, or in the working directory
    ./policies/NAME     in the working directory
    waypointctl's own   the policies that are installed with it
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Final

FLAGSHIP: Final = "ant-waypoint"
SHIPPED: Final = (FLAGSHIP,)  # installed with the package: pyproject.toml puts their folders into the wheel
POLICIES: Final = Path("policies")

_MANIFEST: Final = "manifest.json"
_PACKAGE: Final = Path(__file__).resolve().parents[1]
_MOST_NAMED: Final = 20  # policies in a message
_MOST_NEAR: Final = 3  # of those near a folder that is not a policy
_MOST_SEEN: Final = 2000  # folders looked at: the named one may be a whole disk


def policy_folder(named: str, beside: Path = Path()) -> Path:
    """Return the folder of a policy; where there is none, the path itself, which `load_policy` refuses.

    Args:
        named: a path, or a bare name.
        beside: the folder that a path is relative to.
    """
    path = beside / named
    if not is_bare(named):
        return path
    places = (path, POLICIES / named, *([shipped_folder(named)] if named in SHIPPED else ()))
    holding = (place for place in places if os.path.isfile(place / _MANIFEST))
    there = (place for place in places if os.path.isdir(place))
    return next(holding, None) or next(there, path)


def policy_reference(named: str, beside: Path | None) -> str:
    """Return what a mission or a recipe is to call the policy that is named in the working directory.

    Args:
        named: a path, or a bare name.
        beside: the folder of the file; None where it is not known, such as of one that is written to stdout.
    """
    folder = policy_folder(named)
    if named in SHIPPED and folder == shipped_folder(named):
        return named
    if beside is not None:
        return os.path.relpath(folder, beside)
    if folder.parent == POLICIES and policy_folder(folder.name) == folder:
        return folder.name  # found from any folder, as long as the working directory is this one
    return os.path.abspath(folder) if folder.exists() else named


def from_folder(named: str, folder: Path) -> str:
    """Return a name as it is, and a path that is relative to a folder as one that is relative to the working directory.

    A robot is named like this: its folder always with a slash, so that it cannot be taken for a name.
    """
    return named if is_bare(named) or folder == Path() else os.path.join(folder, named)


def is_bare(named: str) -> bool:
    """Return whether this is a name to look for, and no path."""
    return named not in ("", ".", "..") and not any(mark in named for mark in (os.sep, os.altsep or os.sep, "\0"))


def shipped_folder(name: str) -> Path:
    """Return the folder of a policy that comes with waypointctl: in the package, or beside it in a checkout."""
    installed = _PACKAGE / POLICIES
    return (installed if installed.is_dir() else _PACKAGE.parent / POLICIES) / name


def is_installed(folder: Path) -> bool:
    """Return whether a folder is within the installed package, where nothing else is to be written."""
    return folder.resolve().is_relative_to(_PACKAGE)


def policies_there_are(named: str = "") -> str:
    """Return, as a hint, which policies can be named from the working directory, and the one that was nearly named."""
    import difflib  # 10 ms that a good name need not wait for

    local = sorted(_local())
    shipped = [f"{name} (shipped with waypointctl)" for name in SHIPPED if name not in local]
    listed = [*shipped, *(str(POLICIES / name) for name in local)]
    more = f" and {len(listed) - _MOST_NAMED} more" if len(listed) > _MOST_NAMED else ""
    near = difflib.get_close_matches(named, [*SHIPPED, *local], n=1)
    meant = f". Did you mean {near[0]!r}?" if near else "."
    return f"A policy is a folder with {_MANIFEST}, or a name. There is {', '.join(listed[:_MOST_NAMED])}{more}{meant}"


def known_folders() -> list[Path]:
    """Return the folders of the policies that `waypointctl policies` lists."""
    return [*map(shipped_folder, SHIPPED), *(POLICIES / name for name in sorted(_local()))]


def _local() -> Iterator[str]:
    """Yield the names of the policies in ./policies."""
    try:
        with os.scandir(POLICIES) as entries:
            yield from (each.name for each in islice(entries, _MOST_SEEN) if os.path.isfile(Path(each, _MANIFEST)))
    except OSError:
        return


def policies_near(folder: Path) -> str:
    """Return which folders in a folder, or in the folders in it, are policies, the newest first, as a hint."""
    for found in (_policies(folders) for folders in (_folders(folder), _folders_in_folders(folder))):
        if found:
            more = f" and {len(found) - _MOST_NEAR} more" if len(found) > _MOST_NEAR else ""
            names = ", ".join(str(path) for path in found[:_MOST_NEAR])
            return (
                f"Policies in it are {names}{more}: give one of these." if len(found) > 1 else f"Did you mean {names}?"
            )
    return policies_there_are()


def _policies(folders: Iterator[Path]) -> list[Path]:
    dated = []
    for folder in islice(folders, _MOST_SEEN):
        try:
            dated.append((-(folder / _MANIFEST).stat().st_mtime_ns, folder))
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
