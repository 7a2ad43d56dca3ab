"""Trials that a policy was chosen by: they flatter it, and are no result of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer

from waypointctl.cli.evaluation_run import ChosenSuite
from waypointctl.display_text import printable
from waypointctl.errors import InputError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import SelectionRecord


def refuse_selection_trials(
    loaded: Sequence[tuple[Path, LoadedPolicy]], suite: ChosenSuite, seed: int, *, save: bool
) -> None:
    """Refuse to save an evaluation in the very trials that a policy was chosen by; warn of one that is not saved.

    Raises:
        InputError: one of the policies was chosen by them, and the evaluation is to be saved.
    """
    for folder, policy in loaded:
        record = policy.manifest.training.selection
        if record is None or record.seed != seed or not _is_suite_of(record, suite):
            continue
        problem = (
            f"policy {policy.manifest.name!r} was chosen among its checkpoints by its success in {record.suite!r} with "
            f"seed {seed}, by these very trials, so they flatter it"
        )
        if save:
            hint = "Give another --seed; without --save the trials are walked with a warning."
            raise InputError(f"--save: {problem}", where=str(folder), hint=hint)
        typer.echo(f"warning: {printable(folder)}: {printable(problem)}; another --seed does not", err=True)


def _is_suite_of(record: SelectionRecord, suite: ChosenSuite) -> bool:
    """Return whether a selection was by this suite; of a file it has the path that its recipe gave."""
    recorded = Path(record.suite)
    return suite.own.name in (record.suite, recorded.stem) or recorded.name == Path(suite.asked).name
