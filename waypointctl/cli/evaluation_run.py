"""Evaluating policies by their folders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from waypointctl.evaluation.conditions import parse_acceptance
from waypointctl.evaluation.evaluate import Progress, evaluate
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.rollout import Walks
from waypointctl.evaluation.suite import Suite, Walked, load_suite
from waypointctl.mission.fields import Acceptance
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.training.trained_on import trained_on


@dataclass(frozen=True, slots=True)
class Evaluated:
    """A policy's folder, what its evaluation found, and the trials by case."""

    folder: Path
    evaluation: Evaluation
    walks: Mapping[str, Walks]


@dataclass(frozen=True, slots=True)
class ChosenSuite:
    """A suite as it is, and as it is to be walked: with another acceptance region, maybe.

    Attributes:
        asked: the name or the file that it was asked for by.
        own: as it is.
        walked: as it is to be walked.
    """

    asked: str
    own: Suite
    walked: Suite

    @property
    def other_acceptance(self) -> Acceptance | None:
        """The region that takes the place of the suite's own, None where it is the suite's."""
        return None if self.own.acceptance == self.walked.acceptance else self.walked.acceptance


def chosen_suite(name_or_file: str, acceptance: str | None) -> ChosenSuite:
    """Return a suite, with the acceptance "SHAPE:SIZE" in place of its own if there is one.

    Raises:
        SuiteError: there is no such suite, or it is not one.
        InputError: the acceptance is none.
    """
    own = load_suite(name_or_file)
    walked = own if acceptance is None else own.accepting(parse_acceptance(acceptance))
    return ChosenSuite(name_or_file, own, walked)


def load_folders(folders: Sequence[Path]) -> list[tuple[Path, LoadedPolicy]]:
    """Load the policy in each folder.

    Raises:
        PolicyError: one is missing or damaged.
    """
    return [(folder, load_policy(folder)) for folder in folders]


def evaluate_loaded(
    loaded: Sequence[tuple[Path, LoadedPolicy]],
    suite: ChosenSuite,
    trials: int | None,
    seed: int,
    threads: int = 0,
    progress: Progress | None = None,
) -> list[Evaluated]:
    """Evaluate policies one after the other.

    Args:
        loaded: each with its folder; what it was trained on is read from the recipe there.
        suite: the paths.
        trials: of each case; None: as many as the suite says.
        seed: of the starts and of random paths.
        threads: of the physics; 0 is one a core, 8 at most.
        progress: told of every policy's trials.

    Raises:
        PolicyError: a policy was made for something else.
    """
    own = None if suite.other_acceptance is None else suite.own.acceptance
    found = []
    for folder, policy in loaded:
        walks = _Walks()
        evaluation = evaluate(policy, suite.walked, trials, seed, threads, progress, watch=walks.keep)
        told = {"suite_acceptance": own, "training": trained_on(folder, policy.manifest)}
        found.append(Evaluated(folder, evaluation.model_copy(update=told), walks.by_case))
    return found


class _Walks:
    def __init__(self) -> None:
        self.by_case: dict[str, Walks] = {}

    def keep(self, case: Walked, walks: Walks) -> None:
        self.by_case[case.name] = walks
