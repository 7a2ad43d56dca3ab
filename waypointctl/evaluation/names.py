"""Names of evaluated policies in tables and pictures, each different."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path

from waypointctl.evaluation.result import Evaluation


def names_of(evaluations: Sequence[Evaluation], folders: Sequence[Path] | None = None) -> list[str]:
    """Return what each policy is called: its name, where others have the same name its folder.

    Without folders the beginning of its hash is added; equal names are numbered.
    """
    known = Counter(evaluation.policy for evaluation in evaluations)
    names = [
        evaluation.policy
        if known[evaluation.policy] == 1
        else _told_apart(evaluation, folders[place] if folders else None)
        for place, evaluation in enumerate(evaluations)
    ]
    return _numbered(names)


def notes_on_names(evaluations: Sequence[Evaluation], names: Sequence[str]) -> tuple[str, ...]:
    """Return a line on each group of policies that are one and the same, and on each name that several go by."""
    by_content, by_name = defaultdict(list), defaultdict(set)
    for evaluation, name in zip(evaluations, names, strict=True):
        by_content[evaluation.policy_sha256].append(name)
        by_name[evaluation.policy].add(evaluation.policy_sha256)
    same = [
        f"{_listed(group)} are one and the same policy: SHA-256 {content[:7]}..."
        for content, group in by_content.items()
        if len(group) > 1
    ]
    clashing = [
        f"{len(contents)} different policies are called {name!r}"
        for name, contents in by_name.items()
        if len(contents) > 1
    ]
    return (*same, *clashing)


def _told_apart(evaluation: Evaluation, folder: Path | None) -> str:
    return f"{evaluation.policy} {evaluation.policy_sha256[:7]}" if folder is None else str(folder)


def _numbered(names: Sequence[str]) -> list[str]:
    """Return the names, those that are there more than once with a number."""
    counts = Counter(names)
    numbers = {name: iter(range(1, count + 1)) for name, count in counts.items()}
    return [f"{name} ({next(numbers[name])})" if counts[name] > 1 else name for name in names]


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"
