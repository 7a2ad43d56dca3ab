"""Evaluations as files, in their policy's folder or at a given path; and the policies in a folder with theirs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import BaseModel, TypeAdapter, ValidationError

from waypointctl.errors import InputError, OutputError, PolicyError, SuiteError
from waypointctl.evaluation.result import EVALUATION, Evaluation, evaluations_json, read_evaluation
from waypointctl.evaluation.suite import BUILT_IN, Suite, load_suite
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.mission.checks import file_name
from waypointctl.mission.fields import Acceptance
from waypointctl.mission.policy_name import POLICIES, SHIPPED, policy_folder, shipped_folder
from waypointctl.paths import folder_fault, write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import MANIFEST

PATTERN: Final = "evaluation*.json"  # names of evaluation files in a policy's folder

_PAPER: Final = "paper"


class _Several(BaseModel):
    evaluations: tuple[Evaluation, ...]


_EITHER: Final[TypeAdapter[Evaluation | _Several]] = TypeAdapter(Evaluation | _Several)


def write_evaluations(evaluations: Sequence[Evaluation], path: Path) -> None:
    """Write one evaluation as it is, several as {"evaluations": [...]}; the file appears whole.

    Raises:
        OutputError: the file cannot be written.
    """
    write_whole(path, evaluations_json(evaluations).encode(), "the evaluation")


def saved_name(suite: str, other_acceptance: Acceptance | None = None) -> str:
    """Return the name of an evaluation's file in its policy's folder.

    There is one for each suite, and one more for each acceptance region that is not the suite's own.
    """
    if other_acceptance is not None:
        return f"evaluation-{suite}-{other_acceptance.shape}-{other_acceptance.size_m:g}m.json"
    return EVALUATION if suite == _PAPER else f"evaluation-{suite}.json"


def remove_outdated(folder: Path, policy_sha256: str) -> None:
    """Remove an earlier policy's evaluations from a folder before another policy is written to it.

    evaluation.json goes in any case; those in other suites stay if they are of the very same policy.

    Raises:
        OutputError: one cannot be removed.
    """
    for path in folder.glob(PATTERN):
        try:
            if path.name == EVALUATION or _is_of_another(path, policy_sha256):
                path.unlink(missing_ok=True)
        except OSError as error:
            raise OutputError(f"cannot be replaced: {error.strerror}", where=str(path)) from error


def _is_of_another(path: Path, policy_sha256: str) -> bool:
    try:
        return read_evaluation(path).policy_sha256 != policy_sha256
    except InputError:
        return False  # not what --save wrote


def refuse_unsavable(suite: Suite) -> None:
    """Refuse a suite whose results would have the same file name as another suite's.

    Raises:
        SuiteError: its name cannot name a file, or is that of a suite that comes with waypointctl and is another.
    """
    try:
        file_name(suite.name)
    except ValueError as error:
        raise SuiteError(f"--save names a file after the suite, and {error}", hint="rename the suite") from error
    if suite.name in BUILT_IN and suite != load_suite(suite.name):
        problem = f"a suite that comes with waypointctl has the name {suite.name!r}"
        raise SuiteError(problem, hint="rename your suite, so that --save keeps the results of both")


def refuse_other_files(path: Path) -> None:
    """Refuse to replace a file unless it is an evaluation or empty.

    Raises:
        OutputError: it is something else.
    """
    if not path.is_file() or is_evaluations(read_input(path, RECORD_FILE, OutputError, hint="name another file")):
        return
    raise OutputError(
        "already exists and is not an evaluation",
        where=str(path),
        hint="use --force to replace it, or name another file",
    )


def refuse_fewer_trials(path: Path, trials: int) -> None:
    """Refuse to replace evaluations by one with fewer trials of a case.

    Args:
        path: of a file that `refuse_other_files` has let pass, or of none.
        trials: of each case of the new evaluation.

    Raises:
        OutputError: a case in the file has more trials.
    """
    text = read_input(path, RECORD_FILE, OutputError, hint="name another file") if path.is_file() else b""
    if not text.strip():
        return
    found = _EITHER.validate_json(text)
    evaluations = found.evaluations if isinstance(found, _Several) else (found,)
    stored = max((case.trials for evaluation in evaluations for case in evaluation.cases), default=0)
    if stored > trials:
        problem = f"has an evaluation with {stored:,} trials of each path; this one has {trials:,}"
        raise OutputError(problem, where=str(path), hint=f"use --force to replace it, or --trials {stored}")


def is_evaluations(text: bytes) -> bool:
    """Return whether a file's text is what `write_evaluations` writes, or nothing."""
    if not text.strip():
        return True
    try:
        _EITHER.validate_json(text)
    except ValidationError:
        return False
    return True


@dataclass(frozen=True, slots=True)
class Entry:
    """A folder with a policy, its evaluations, and the errors in any of these files."""

    folder: Path
    policy: LoadedPolicy | None
    evaluations: tuple[Evaluation, ...]  # the paper's first, then the suites that come with waypointctl, then others
    faults: tuple[str, ...]
    shipped: bool = False  # it comes with waypointctl, and is found by its name unless ./policies has one of that name

    @property
    def name(self) -> str:
        """Its folder's, by which a policy in ./policies and one that comes with waypointctl are found."""
        return self.folder.name


def known_policies() -> list[Entry]:
    """Return an entry for each policy that a bare name finds: those that come with waypointctl, and in ./policies."""
    own = [shipped_folder(name) for name in SHIPPED if policy_folder(name) == shipped_folder(name)]
    found = [entry_of(folder) for folder in own]
    return found + (catalogue(POLICIES) if os.path.isdir(POLICIES) else [])


def catalogue(folder: Path) -> list[Entry]:
    """Return an entry for each folder in `folder` that has a manifest.json, by name.

    Raises:
        PolicyError: `folder` is not a folder.
    """
    if fault := folder_fault(folder):
        raise PolicyError(fault, where=str(folder), hint="use a folder that contains policies")
    return [entry_of(manifest.parent) for manifest in sorted(folder.glob(f"*/{MANIFEST}"))]


def entry_of(folder: Path) -> Entry:
    """Return the entry of a policy's folder."""
    policy, evaluations, faults = None, [], []
    try:
        policy = load_policy(folder)
    except InputError as error:
        faults.append(f"{error.where}: {error.problem}")
    for path in sorted(folder.glob(PATTERN), key=_rank):
        try:
            evaluation = read_evaluation(path)
        except InputError as error:
            faults.append(f"{error.where}: {error.problem}")
            continue
        if policy is None or evaluation.policy_sha256 == policy.sha256:
            evaluations.append(evaluation)
        else:
            faults.append(f"{path}: of another policy than the one in this folder")
    return Entry(folder, policy, tuple(evaluations), tuple(faults), folder in map(shipped_folder, SHIPPED))


def _rank(path: Path) -> tuple[int, str]:
    names = [EVALUATION, *(saved_name(suite) for suite in BUILT_IN)]
    return (names.index(path.name) if path.name in names else len(names), path.stem)
