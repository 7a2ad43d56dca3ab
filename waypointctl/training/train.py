"""Training from a recipe to a policy bundle with its evaluation."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from waypointctl.errors import OutputError
from waypointctl.evaluation.evaluate import Progress, evaluate
from waypointctl.evaluation.result import EVALUATION, Evaluation
from waypointctl.evaluation.suite import load_suite
from waypointctl.paths import refuse_unwritable_folder
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.write import copy_bundle
from waypointctl.training.checkpoint import load_checkpoint, save_checkpoint
from waypointctl.training.divergence import refuse_diverged
from waypointctl.training.learner import Learner
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import RECIPE, held, newest_checkpoint, require_checkpoint
from waypointctl.training.scalars import scalar_logger
from waypointctl.training.status import CheckpointSaved
from waypointctl.training.watcher import Watch, Watcher


@dataclass(frozen=True, slots=True)
class Trained:
    """What a training came to.

    Attributes:
        policy: as it stands in `folder`.
        folder: the bundle; the last checkpoint's if the training was interrupted.
        evaluation: on the paper's cases; None if the training was interrupted.
    """

    policy: LoadedPolicy
    folder: Path
    evaluation: Evaluation | None


class _Interrupted(Exception):
    """The evaluation is to end."""


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
        run: the run's folder, for checkpoints and TensorBoard scalars.
        threads: of physics and of torch; 0 is one a core.
        resume: go on from the newest checkpoint in `run`.
        watch: told how it goes.
        evaluating: told how the evaluation goes.
        interrupted: asked before every rollout and while evaluating; True ends the training.

    Raises:
        OutputError: `out` or `run` cannot be written, or `run` is of an earlier training that is not to be resumed.
        RecipeError: there is no checkpoint to resume from, or it is damaged or of another recipe; or the training
            diverged.
    """
    refuse_unwritable_folder(out)
    with held(run):
        learner = Learner(recipe_file.recipe, threads)
        spent_s = _begin(learner, recipe_file, run, resume)
        watcher = _learn(learner, recipe_file, run, spent_s, watch, interrupted)
        saved = watcher.saved
        assert saved is not None, "every training ends with a checkpoint"
        policy = load_policy(saved.folder)
        plan = recipe_file.recipe.evaluation
        evaluation = None
        if not watcher.stopped:
            evaluation = _evaluate(policy, plan.trials, plan.seed, threads, evaluating, interrupted)
        if evaluation is None:
            return Trained(policy, saved.folder, evaluation=None)
        _finish(policy, recipe_file, evaluation, out)
        return Trained(policy, out, evaluation)


def _begin(learner: Learner, recipe_file: RecipeFile, run: Path, resume: bool) -> float:
    """Return the wall time spent until now [s]."""
    if resume:
        return load_checkpoint(learner, recipe_file, require_checkpoint(run))
    if newest_checkpoint(run):
        problem = "has the checkpoints of an earlier training"
        raise OutputError(problem, where=str(run), mend="Resume that training, or choose another folder.")
    _place_recipe(recipe_file, run)
    return 0.0


def _learn(
    learner: Learner,
    recipe_file: RecipeFile,
    run: Path,
    spent_s: float,
    watch: Watch,
    interrupted: Callable[[], bool],
) -> Watcher:
    begun_s = time.monotonic() - spent_s

    def save() -> CheckpointSaved:
        folder = save_checkpoint(learner, recipe_file, run, time.monotonic() - begun_s)
        return CheckpointSaved(learner.steps, folder)

    def refuse() -> None:
        refuse_diverged(learner, recipe_file, run)

    watcher = Watcher(learner, watch=watch, save=save, refuse_diverged=refuse, interrupted=interrupted, begun_s=begun_s)
    with scalar_logger(run / "tensorboard", learner.steps) as logger:
        learner.ppo.set_logger(logger)
        try:
            learner.learn(watcher)
        except ValueError:  # torch's distributions refuse numbers that are not finite in the middle of an update
            refuse()
            raise
    return watcher


def _evaluate(
    policy: LoadedPolicy,
    trials: int,
    seed: int,
    threads: int,
    evaluating: Progress,
    interrupted: Callable[[], bool],
) -> Evaluation | None:
    """Return how the policy does on the paper's cases, None if that was interrupted."""

    def progress(case: str, ended: int) -> None:
        if interrupted():
            raise _Interrupted
        evaluating(case, ended)

    try:
        return evaluate(policy, load_suite("paper"), trials, seed, threads, progress)
    except _Interrupted:
        return None


def _finish(policy: LoadedPolicy, recipe_file: RecipeFile, evaluation: Evaluation, out: Path) -> None:
    """Put the bundle into `out`; the evaluation of an earlier one is never beside it."""
    try:
        (out / EVALUATION).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot be replaced: {error.strerror}", where=str(out / EVALUATION)) from error
    copy_bundle(policy, out)
    _place_recipe(recipe_file, out)
    _place(out / EVALUATION, evaluation.to_json().encode())


def _place_recipe(recipe_file: RecipeFile, folder: Path) -> None:
    path = folder / RECIPE
    if not (path.exists() and path.samefile(recipe_file.path)):
        _place(path, recipe_file.source)


def _place(path: Path, content: bytes) -> None:
    """Write a file so that it appears whole."""
    part = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        part.write_bytes(content)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OutputError(f"cannot be written: {error.strerror}", where=str(path)) from error
