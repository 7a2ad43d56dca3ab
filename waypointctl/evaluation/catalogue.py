"""The policies in a folder, and what is known of each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from waypointctl.errors import InputError, PolicyError
from waypointctl.evaluation.result import EVALUATION, Evaluation, read_evaluation
from waypointctl.paths import folder_fault
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import MANIFEST


@dataclass(frozen=True, slots=True)
class Entry:
    """A folder with a policy, what evaluation.json beside it says, and what is wrong with either."""

    folder: Path
    policy: LoadedPolicy | None
    evaluation: Evaluation | None
    faults: tuple[str, ...]


def catalogue(folder: Path) -> list[Entry]:
    """Return an entry for each folder in `folder` that has a manifest.json, by name.

    Raises:
        PolicyError: `folder` is not a folder.
    """
    if fault := folder_fault(folder):
        raise PolicyError(fault, where=str(folder), mend="give a folder that has policies in it")
    return [_entry(manifest.parent) for manifest in sorted(folder.glob(f"*/{MANIFEST}"))]


def _entry(folder: Path) -> Entry:
    policy, evaluation, faults = None, None, []
    try:
        policy = load_policy(folder)
    except InputError as error:
        faults.append(f"{error.where}: {error.problem}")
    try:
        evaluation = read_evaluation(folder / EVALUATION) if (folder / EVALUATION).exists() else None
    except InputError as error:
        faults.append(f"{error.where}: {error.problem}")
    if policy and evaluation and evaluation.policy_sha256 != policy.sha256:
        faults.append(f"{folder / EVALUATION}: of another policy than the one beside it")
        evaluation = None
    return Entry(folder, policy, evaluation, tuple(faults))
