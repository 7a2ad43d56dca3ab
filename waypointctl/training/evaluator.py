"""Evaluating policies during and after training, so that it can be interrupted."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from waypointctl.errors import InputError, SuiteError
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.result import EVALUATION, Evaluation, read_evaluation
from waypointctl.evaluation.suite import Suite, load_suite
from waypointctl.mission.yaml_source import read_source
from waypointctl.paths import write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.training.events import CheckpointEvaluated, CheckpointSaved, EvaluationProgress, OnEvent
from waypointctl.training.recipe_file import RecipeFile, own_suite
from waypointctl.training.selection import Candidate, EvaluationRecipe, Selection, SelectionRecipe

SUITE: Final = "selection-suite.yaml"  # a run's copy of a user's suite


class _Interrupted(Exception):
    """The evaluation is to end."""


@dataclass(frozen=True, slots=True)
class Evaluator:
    """Evaluates policies of a training. It draws from streams of its own: training is the same without it.

    Attributes:
        recipe_file: of the training, with its plugins; its robot is that of a suite without one.
        threads: of the physics; 0 is one per core, 8 at most.
        on_event: called with the progress.
        interrupted: called during the evaluation; True ends it.
    """

    recipe_file: RecipeFile
    threads: int
    on_event: OnEvent
    interrupted: Callable[[], bool]

    def evaluate(
        self, policy: LoadedPolicy, suite: Suite, plan: EvaluationRecipe | SelectionRecipe
    ) -> Evaluation | None:
        """Return how a policy does in a suite, None if that was interrupted."""
        final = isinstance(plan, EvaluationRecipe)

        def progress(case: str, ended: int) -> None:
            if self.interrupted():
                raise _Interrupted
            self.on_event(EvaluationProgress(suite.name, final, case, ended, plan.trials))

        robot = suite.robot or self.recipe_file.recipe.robot_path
        plugins = self.recipe_file.plugins
        try:
            return evaluate(policy, suite, plan.trials, plan.seed, self.threads, progress, plugins=plugins, robot=robot)
        except _Interrupted:
            return None


@dataclass(frozen=True, slots=True)
class CheckpointSelector:
    """Evaluates checkpoints for a selection.

    Attributes:
        selection: of the best of them.
        suite: the paths.
        evaluator: what evaluates.
        begun_s: when training began, on the clock of time.monotonic, earlier sessions included.
    """

    selection: Selection
    suite: Suite
    evaluator: Evaluator
    begun_s: float

    def evaluate(self, saved: CheckpointSaved) -> Candidate | None:
        """Evaluate a checkpoint; return None if that was interrupted, so that it is still to be evaluated."""
        evaluation = self.evaluator.evaluate(load_policy(saved.folder), self.suite, self.selection.recipe)
        if evaluation is None:
            return None
        cases = evaluation.cases
        candidate = Candidate(
            steps=saved.steps,
            wall_time_s=round(time.monotonic() - self.begun_s, 1),
            trials=sum(case.trials for case in cases),
            successes=sum(case.successes for case in cases),
            falls=sum(case.falls for case in cases),
        )
        self.selection.add(candidate)
        best = self.selection.best
        self.evaluator.on_event(
            CheckpointEvaluated(
                candidate.steps,
                candidate.trials,
                candidate.success_rate,
                best.steps,
                best.success_rate,
                self.selection.recipe.stop_at,
            )
        )
        return candidate


def selection_suite(recipe_file: RecipeFile, run: Path, *, resume: bool) -> Suite | None:
    """Return the suite that a run's checkpoints are evaluated on; None if they are not.

    The path of a user's suite is relative to the recipe; the run keeps a copy for --resume.

    Raises:
        SuiteError: the suite does not exist, or the file is not a suite.
        OutputError: the copy cannot be written.
    """
    if recipe_file.recipe.selection is None:
        return None
    if resume and (run / SUITE).exists():
        return load_suite(str(run / SUITE))
    name = recipe_file.recipe.selection.suite
    own = own_suite(name, recipe_file.path)
    suite = load_suite(name if own is None else str(own))
    if own is not None:
        write_whole(run / SUITE, read_source(own, SuiteError), "the suite")
    return suite


def final_evaluation(
    policy: LoadedPolicy, suite: Suite, evaluator: Evaluator, out: Path, *, complete: bool
) -> Evaluation | None:
    """Return the policy's final evaluation, None if that was interrupted.

    The evaluation in `out` of an already complete training is kept, if it is of this policy and these trials.
    """
    plan = evaluator.recipe_file.recipe.evaluation
    wanted = (suite.name, plan.seed, policy.sha256, {plan.trials})
    if complete:
        with suppress(InputError):
            found = read_evaluation(out / EVALUATION)
            if (found.suite, found.seed, found.policy_sha256, {case.trials for case in found.cases}) == wanted:
                return found
    return evaluator.evaluate(policy, suite, plan)
