"""The folder of a run, or of a group of runs: where it is, who may write it, and what a training puts where.

runs/ant-waypoint/        the run, named for its recipe: -2, -3, ... where the name is taken
    train.yaml            the recipe as it was when the run began
    robot/ plugins/       copies of the robot and the plugins that it names
    checkpoints/step-.../ each a bundle, and all that training needs to continue
    progress.csv          how it went, a row for each rollout
    selection.json        results of the evaluated checkpoints, if the recipe has a selection
    tensorboard/          scalars
    manifest.json ...     the bundle and its evaluation, when it is complete and goes nowhere else

runs/ant-waypoint-seeds/  a group: one recipe trained with several seeds, resumed as a whole
    group.json            the options of its runs
    seed-0/ seed-1/ ...   the runs; each its own bundle's folder too
    curves.csv curves.png how they went, when all have ended
    seeds.json            their results
"""

from __future__ import annotations

import fcntl
import itertools
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from waypointctl.errors import OutputError, RecipeError
from waypointctl.paths import open_lock, refuse_unwritable_folder
from waypointctl.policy.manifest import MANIFEST

FOLDER: Final = "checkpoints"
PLUGIN_COPIES: Final = "plugins"
GROUP: Final = "group.json"

_LOCK: Final = ".lock"

_ELSEWHERE: Final = "Give a folder in a place that you can write to."


@dataclass(frozen=True, slots=True)
class Places:
    """Where a training writes.

    Attributes:
        run: the run's folder.
        out: where the bundle goes when it is complete.
    """

    run: Path
    out: Path


def places(name: str, runs: Path, out: Path | None, *, resume: bool) -> Places:
    """Return where a training of the recipe `name` writes; a new run's folder is made.

    Args:
        name: of the recipe.
        runs: the folder of all runs.
        out: where the bundle shall go; a folder in `runs` is the run's folder at the same time.
        resume: continue a run: `out` if that is one, else the newest of that name.

    Raises:
        RecipeError: there is no run to continue, or the newest has no checkpoint.
        OutputError: a folder cannot be written.
    """
    if out is not None:
        refuse_unwritable_folder(out)
        if out.resolve().parent == runs.resolve():
            return Places(out, out)
    refuse_unwritable_folder(runs)
    run = _newest_run(name, runs) if resume else new_run(name, runs)
    return Places(run, out or run)


def keeps_copies(folder: Path) -> bool:
    """Return whether a folder is that of a run or a policy, where a recipe's robot and plugins are copies."""
    return any((folder / name).exists() for name in (_LOCK, FOLDER, MANIFEST))


def group_place(name: str, runs: Path, out: Path | None, *, resume: bool) -> Path:
    """Return the folder of a group of the recipe `name`; a new one is made.

    Args:
        name: of the recipe.
        runs: the folder of all runs.
        out: the group's folder, if it is not to be one in `runs`.
        resume: continue a group: `out`, else the one of that name with the latest change.

    Raises:
        RecipeError: there is no group to continue.
        OutputError: a folder cannot be written.
    """
    if out is not None:
        refuse_unwritable_folder(out)
        return out
    refuse_unwritable_folder(runs)
    own = f"{name}-seeds"
    if not resume:
        return new_run(own, runs)
    found = [path for path in _named(own, runs) if (path / GROUP).is_file()]
    if not found:
        hint = "Train without --resume, or name a group's folder with --out."
        raise RecipeError(f"no group of seeds of {name!r} to continue", where=str(runs), hint=hint)
    return max(found, key=_last_worked_on)


def checkpoints(run: Path) -> list[tuple[int, Path]]:
    """Return the control step and the folder of each of a run's checkpoints, oldest first."""
    folders = (run / FOLDER).glob("step-*")
    return sorted((int(path.name[5:]), path) for path in folders if path.name[5:].isdecimal())


def newest_checkpoint(run: Path) -> Path | None:
    """Return the folder of a run's newest checkpoint, None if there is none."""
    found = checkpoints(run)
    return found[-1][1] if found else None


def checkpoint_at(run: Path, steps: int) -> Path:
    """Return the folder of a run's checkpoint at a control step."""
    return run / FOLDER / f"step-{steps:010d}"


def require_checkpoint(run: Path) -> Path:
    """Return the folder of a run's newest checkpoint.

    Raises:
        RecipeError: there is none.
    """
    checkpoint = newest_checkpoint(run)
    if checkpoint is None:
        raise RecipeError("no checkpoint to resume from", where=str(run), hint="Train without --resume.")
    return checkpoint


@contextmanager
def held(run: Path) -> Iterator[None]:
    """Make a run's folder and keep every other training out of it.

    Raises:
        OutputError: it cannot be written, or another training is at it.
    """
    try:
        run.mkdir(parents=True, exist_ok=True)
        lock = open_lock(run / _LOCK)
    except OSError as error:
        raise OutputError(f"the run cannot be written: {error.strerror}", where=str(run), hint=_ELSEWHERE) from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # released when the process ends, in any way
        except BlockingIOError:
            raise OutputError("another training is writing this run", where=str(run)) from None
        for killed in (run / FOLDER).glob(".*.tmp"):
            shutil.rmtree(killed, ignore_errors=True)
        yield


def new_run(name: str, runs: Path) -> Path:
    """Make a folder in `runs` of the first name that is free, of NAME, NAME-2, NAME-3, ..., and return it.

    Raises:
        OutputError: it cannot be made.
    """
    names = itertools.chain([name], (f"{name}-{number}" for number in itertools.count(2)))
    return next(path for path in (runs / name for name in names) if _made(path))


def _made(path: Path) -> bool:
    try:
        path.mkdir(parents=True)
    except FileExistsError:
        return False
    except OSError as error:
        raise OutputError(f"the run cannot be made: {error.strerror}", where=str(path), hint=_ELSEWHERE) from error
    return True


def _last_worked_on(group: Path) -> int:
    newest = [newest_checkpoint(run) for run in group.glob("seed-*")]
    return max(path.stat().st_mtime_ns for path in (group / GROUP, *newest) if path is not None)


def _newest_run(name: str, runs: Path) -> Path:
    """Return the run of that name with the latest change.

    If the newest was killed before its first checkpoint, an older one is not used instead.
    """
    found = [(newest_checkpoint(path), path) for path in _named(name, runs)]
    if not any(checkpoint for checkpoint, _ in found):
        hint = "Train without --resume, or name a run's folder with --out."
        raise RecipeError(f"no run of {name!r} with a checkpoint to resume from", where=str(runs), hint=hint)
    checkpoint, newest = max(found, key=lambda one: (one[0] or one[1]).stat().st_mtime_ns)
    if checkpoint is None:
        hint = "Name the run to continue with --out, or train without --resume."
        raise RecipeError(f"the newest run {newest} has no checkpoint", where=str(runs), hint=hint)
    return newest


def _named(name: str, runs: Path) -> list[Path]:
    """Return the folders in `runs` of a name, with a number or without."""
    own = re.compile(rf"{re.escape(name)}(-[0-9]+)?")
    return [path for path in runs.iterdir() if own.fullmatch(path.name) and path.is_dir()] if runs.is_dir() else []
