"""The policies in a folder, with their evaluations."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

from waypointctl.errors import InputError, PolicyError
from waypointctl.evaluation.result import EVALUATION, Evaluation, read_evaluation
from waypointctl.evaluation.saved import PATTERN, saved_name
from waypointctl.evaluation.suite import BUILT_IN
from waypointctl.mission.policy_name import POLICIES, SHIPPED, policy_folder, shipped_folder
from waypointctl.paths import folder_fault
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import MANIFEST


@dataclass(frozen=True, slots=True)
class Entry:
    """A folder with a policy, its evaluations, and the errors in any of these files.

    Attributes:
        shipped: it comes with waypointctl, and is found by its name unless ./policies has one of that name.
    """

    folder: Path
    policy: LoadedPolicy | None
    evaluations: tuple[Evaluation, ...]  # the paper's first, then the suites that come with waypointctl, then others
    faults: tuple[str, ...]
    shipped: bool = False

    @property
    def name(self) -> str:
        """Its folder's, by which a policy in ./policies and one that comes with waypointctl are found."""
        return self.folder.name


def known_policies() -> list[Entry]:
    """Return an entry for each policy that a bare name finds: those that come with waypointctl, and in ./policies."""
    own = [shipped_folder(name) for name in SHIPPED if policy_folder(name) == shipped_folder(name)]
    found = [replace(_entry(folder), shipped=True) for folder in own]
    return found + (catalogue(POLICIES) if os.path.isdir(POLICIES) else [])


def catalogue(folder: Path) -> list[Entry]:
    """Return an entry for each folder in `folder` that has a manifest.json, by name.

    Raises:
        PolicyError: `folder` is not a folder.
    """
    if fault := folder_fault(folder):
        raise PolicyError(fault, where=str(folder), hint="use a folder that contains policies")
    return [_entry(manifest.parent) for manifest in sorted(folder.glob(f"*/{MANIFEST}"))]


def _entry(folder: Path) -> Entry:
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
    return Entry(folder, policy, tuple(evaluations), tuple(faults))


def _rank(path: Path) -> tuple[int, str]:
    names = [EVALUATION, *(saved_name(suite) for suite in BUILT_IN)]
    return (names.index(path.name) if path.name in names else len(names), path.stem)
