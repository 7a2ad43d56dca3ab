"""Training from a recipe to a policy bundle with its evaluation."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from waypointctl.errors import InputError, OutputError
from waypointctl.evaluation.evaluate import Progress
from waypointctl.evaluation.result import EVALUATION, Evaluation, read_evaluation
from waypointctl.evaluation.saved import remove_outdated
from waypointctl.evaluation.suite import load_suite
from waypointctl.paths import refuse_unwritable_folder, write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.write import copy_bundle
from waypointctl.training.checkpoint import load_checkpoint, save_checkpoint
from waypointctl.training.divergence import refuse_diverged
from waypointctl.training.learner import Learner
from waypointctl.training.origin import load_origin
from waypointctl.training.progress_file import ProgressFile
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import RECIPE, checkpoint_at, held, newest_checkpoint, require_checkpoint
from waypointctl.training.scalars import scalar_logger
from waypointctl.training.selection import Selection, with_record
from waypointctl.training.start_from import start_from
from waypointctl.training.status import CheckpointSaved, Resumed, Threads, Watch
from waypointctl.training.testing import Tester, evaluate_unless, selection_suite
from waypointctl.training.watcher import Watcher


@dataclass(frozen=True, slots=True)
class Trained:
    """What a training came to.

    Attributes:
        policy: as it stands in `folder`.
        folder: the bundle; the last checkpoint's if the training was interrupted.
        evaluation: on the paper's cases; None if the training was interrupted.
        steps: that training went on for; the policy's own are fewer if an earlier checkpoint was selected.
        wall_time_s: of all sessions, without the evaluation.
        selection: the checkpoints that were tested, where the recipe wants that.
        threads: that were used.
        complete_before: a training was resumed that had come to its end already.
    """

    policy: LoadedPolicy
    folder: Path
    evaluation: Evaluation | None
    steps: int
    wall_time_s: float
    selection: Selection | None
    threads: Threads
    complete_before: bool


def train(
    recipe_file: RecipeFile,
    out: Path,
    *,
    run: Path,
    threads: int = 0,
    resume: bool = False,
    watch: Watch = lambda _: None,
    evaluating: Progress = lambda case, ended: None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Trained:
    """Train a policy and write its bundle.

    A training that is interrupted leaves `out` as it was; its last checkpoint is a bundle too, and flies. Resumed
    with as many threads, it ends in the very weights it would have ended in.

    Args:
        recipe_file: what to do.
        out: where the finished bundle goes, with its recipe and evaluation; what is there is replaced.
        run: the run's folder, for checkpoints, progress and TensorBoard scalars.
        threads: of physics and of torch; 0 is the default, or those that the resumed run was trained with.
        resume: go on from the newest checkpoint in `run`.
        watch: told how it goes.
        evaluating: told how the evaluation goes.
        interrupted: asked before every rollout and while evaluating; True ends the training.

    Raises:
        OutputError: `out` or `run` cannot be written, or `run` is of an earlier training that is not to be resumed.
        RecipeError: there is no checkpoint to resume from, or it is damaged or of another recipe; or the training
            diverged, or is to start from a policy of other sizes.
        PolicyError, SuiteError: the policy to start from, or the suite to select by, is not there.
    """
    refuse_unwritable_folder(out)
    with held(run):
        learner = Learner(recipe_file.recipe, threads)
        begun_s = time.monotonic() - _begin(learner, recipe_file, run, resume, watch)
        watch(learner.threads)
        tester = None
        complete = resume and learner.steps >= recipe_file.recipe.total_steps
        if (suite := selection_suite(recipe_file, run, resume=resume)) and (plan := recipe_file.recipe.selection):
            selection = Selection(plan, run, learner.steps, suite.name)
            complete = complete or (resume and selection.met)
            tester = Tester(selection, suite, threads=threads, begun_s=begun_s, watch=watch, interrupted=interrupted)
        if resume:
            watch(Resumed(learner.steps, recipe_file.recipe.total_steps, complete))
        watcher = _learn(learner, recipe_file, run, begun_s, tester, watch, interrupted)
        wall_time_s = time.monotonic() - begun_s
        folder, policy, steps = _chosen(watcher, tester, run)
        evaluation = None
        if not watcher.interrupted:
            kept = _kept_evaluation(policy, recipe_file, out) if complete else None
            evaluation = kept or _evaluate(policy, recipe_file, threads, evaluating, interrupted)
        tested = tester.selection if tester else None
        if evaluation is None:
            policy = load_policy(folder)
        else:
            _finish(policy, recipe_file, evaluation, out)
            folder = out
        return Trained(policy, folder, evaluation, steps, wall_time_s, tested, learner.threads, complete)


def _begin(learner: Learner, recipe_file: RecipeFile, run: Path, resume: bool, watch: Watch) -> float:
    """Return the wall time spent until now [s]."""
    if resume:
        return load_checkpoint(learner, recipe_file, require_checkpoint(run))
    if newest_checkpoint(run):
        problem = "has the checkpoints of an earlier training"
        raise OutputError(problem, where=str(run), hint="Resume that training, or choose another folder.")
    if origin := load_origin(recipe_file):
        watch(start_from(learner, origin, recipe_file))
    _place_recipe(recipe_file, run)
    return 0.0


def _learn(
    learner: Learner,
    recipe_file: RecipeFile,
    run: Path,
    begun_s: float,
    tester: Tester | None,
    watch: Watch,
    interrupted: Callable[[], bool],
) -> Watcher:
    def save() -> CheckpointSaved:
        folder = save_checkpoint(learner, recipe_file, run, time.monotonic() - begun_s)
        return CheckpointSaved(learner.steps, folder)

    def refuse() -> None:
        refuse_diverged(learner, recipe_file, run)

    with scalar_logger(run / "tensorboard", learner.steps) as logger, ProgressFile(run, learner.steps) as progress:
        watcher = Watcher(
            learner,
            watch=watch,
            save=save,
            progress=progress,
            tester=tester,
            refuse_diverged=refuse,
            interrupted=interrupted,
            begun_s=begun_s,
        )
        learner.ppo.set_logger(logger)
        if watcher.met:  # in an earlier session, which was ended in the evaluation
            return watcher
        try:
            learner.learn(watcher)
        except ValueError:  # torch's distributions refuse numbers that are not finite in the middle of an update
            refuse()
            raise
    return watcher


def _chosen(watcher: Watcher, tester: Tester | None, run: Path) -> tuple[Path, LoadedPolicy, int]:
    """Return the checkpoint that becomes the policy, the policy, and the steps that training ended at.

    It is the last one, unless the best was to be selected and training has come to its end.
    """
    if tester is None or watcher.interrupted:
        assert watcher.saved is not None, "every training ends with a checkpoint"
        return watcher.saved.folder, load_policy(watcher.saved.folder), watcher.saved.steps
    folder = checkpoint_at(run, tester.selection.best.steps)
    return folder, with_record(load_policy(folder), tester.selection.record()), tester.selection.last_steps


def _evaluate(
    policy: LoadedPolicy,
    recipe_file: RecipeFile,
    threads: int,
    evaluating: Progress,
    interrupted: Callable[[], bool],
) -> Evaluation | None:
    """Return how the policy does on the paper's cases, None if that was interrupted."""
    plan = recipe_file.recipe.evaluation
    return evaluate_unless(interrupted, policy, load_suite("paper"), plan.trials, plan.seed, threads, evaluating)


def _kept_evaluation(policy: LoadedPolicy, recipe_file: RecipeFile, out: Path) -> Evaluation | None:
    """Return the evaluation that a complete training left in `out`, None if it is not this policy's in these trials."""
    plan = recipe_file.recipe.evaluation
    try:
        found = read_evaluation(out / EVALUATION)
    except InputError:
        return None
    asked = ("paper", plan.seed, policy.sha256, {plan.trials})
    kept = (found.suite, found.seed, found.policy_sha256, {case.trials for case in found.cases})
    return found if kept == asked else None


def _finish(policy: LoadedPolicy, recipe_file: RecipeFile, evaluation: Evaluation, out: Path) -> None:
    """Put the bundle into `out`; evaluations of an earlier one are never beside it."""
    remove_outdated(out, policy.sha256)
    copy_bundle(policy, out)
    _place_recipe(recipe_file, out)
    write_whole(out / EVALUATION, evaluation.to_json().encode(), "the evaluation")


def _place_recipe(recipe_file: RecipeFile, folder: Path) -> None:
    path = folder / RECIPE
    if not (path.exists() and path.samefile(recipe_file.path)):
        write_whole(path, recipe_file.source, "the recipe")
