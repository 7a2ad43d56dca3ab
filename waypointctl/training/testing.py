"""Testing policies while and after they are trained, so that people can stop it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

from waypointctl.errors import SuiteError
from waypointctl.evaluation.evaluate import Progress, evaluate
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.suite import Suite, load_suite
from waypointctl.mission.yaml_source import read_source
from waypointctl.paths import write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.recipe_references import own_suite
from waypointctl.training.selection import Candidate, Selection
from waypointctl.training.status import CheckpointSaved, CheckpointTested, CheckpointTesting, Watch

SUITE: Final = "selection-suite.yaml"  # the copy of a suite of one's own that a run keeps


class _Interrupted(Exception):
    """The evaluation is to end."""


def evaluate_unless(
    interrupted: Callable[[], bool],
    policy: LoadedPolicy,
    suite: Suite,
    trials: int,
    seed: int,
    threads: int,
    progress: Progress,
) -> Evaluation | None:
    """Return how a policy does in a suite, None if that was interrupted."""

    def watched(case: str, ended: int) -> None:
        if interrupted():
            raise _Interrupted
        progress(case, ended)

    try:
        return evaluate(policy, suite, trials, seed, threads, watched)
    except _Interrupted:
        return None


def selection_suite(recipe_file: RecipeFile, run: Path, *, resume: bool) -> Suite | None:
    """Return the suite that a run's checkpoints are tested on; None if they are not.

    A suite of one's own is looked for beside the recipe, and the run keeps a copy to be resumed with.

    Raises:
        SuiteError: there is no such suite, or it is not one.
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


class Tester:
    """Tests checkpoints for a selection. It draws from streams of its own: training is the same without it."""

    def __init__(
        self,
        selection: Selection,
        suite: Suite,
        *,
        threads: int,
        begun_s: float,
        watch: Watch,
        interrupted: Callable[[], bool],
    ) -> None:
        """Test on a suite.

        Args:
            selection: what is found goes there.
            suite: the paths.
            threads: of the physics; 0 is one a core, 8 at most.
            begun_s: when training began, on the clock of time.monotonic, earlier sessions counted in.
            watch: told how it goes.
            interrupted: asked while testing; True ends it.
        """
        self.selection = selection
        self._suite = suite
        self._threads = threads
        self._begun_s = begun_s
        self._watch = watch
        self._interrupted = interrupted

    def test(self, saved: CheckpointSaved) -> bool:
        """Test a checkpoint; return False if that was interrupted, so that it is still to be tested."""
        plan = self.selection.recipe

        def progress(case: str, ended: int) -> None:
            self._watch(CheckpointTesting(case, ended, plan.trials))

        evaluation = evaluate_unless(
            self._interrupted, load_policy(saved.folder), self._suite, plan.trials, plan.seed, self._threads, progress
        )
        if evaluation is None:
            return False
        cases = evaluation.cases
        candidate = Candidate(
            steps=saved.steps,
            wall_time_s=round(time.monotonic() - self._begun_s, 1),
            trials=sum(case.trials for case in cases),
            successes=sum(case.successes for case in cases),
            falls=sum(case.falls for case in cases),
        )
        self.selection.add(candidate)
        best = self.selection.best
        self._watch(
            CheckpointTested(
                candidate.steps, candidate.trials, candidate.success_rate, best.steps, best.success_rate, plan.stop_at
            )
        )
        return True
