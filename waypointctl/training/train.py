"""Training from a recipe to a policy bundle with its evaluation."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from stable_baselines3.common.logger import configure

from waypointctl.errors import OutputError
from waypointctl.evaluation.evaluate import Progress, evaluate
from waypointctl.evaluation.result import EVALUATION, Evaluation, write_evaluation
from waypointctl.evaluation.suite import load_suite
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.training.checkpoint import load_checkpoint, newest_checkpoint, save_checkpoint
from waypointctl.training.export import export_policy
from waypointctl.training.learner import Learner
from waypointctl.training.recipe import RecipeFile
from waypointctl.training.status import CheckpointSaved
from waypointctl.training.watcher import Watch, Watcher

RECIPE: Final = "train.yaml"


@dataclass(frozen=True, slots=True)
class Trained:
    """What a training came to.

    Attributes:
        policy: as it stands in `folder`.
        folder: the bundle.
        steps: control steps of all robots.
        wall_time_s: of training, without the evaluation.
        interrupted: whether it was stopped before its end; then there is no evaluation.
        evaluation: on the paper's cases.
    """

    policy: LoadedPolicy
    folder: Path
    steps: int
    wall_time_s: float
    interrupted: bool
    evaluation: Evaluation | None


def train(
    recipe_file: RecipeFile,
    out: Path,
    *,
    runs: Path,
    threads: int = 0,
    resume: bool = False,
    watch: Watch = lambda _: None,
    evaluating: Progress | None = None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Trained:
    """Train a policy and write its bundle.

    A training that is interrupted leaves `out` as it was; its last checkpoint is a bundle too, and flies.

    Args:
        recipe_file: what to do.
        out: where the finished bundle goes, with its recipe and evaluation.
        runs: the run's folder, for checkpoints and TensorBoard scalars.
        threads: of physics and of torch; 0 is one a core.
        resume: go on from the newest checkpoint in `runs`.
        watch: told how it goes.
        evaluating: told how the evaluation goes.
        interrupted: asked before every rollout; True ends the training.

    Raises:
        OutputError: `out` or `runs` cannot be written.
        RecipeError: there is no checkpoint of this recipe to resume from.
    """
    recipe = recipe_file.recipe
    _prepare(out)
    _prepare(runs)
    learner = Learner(recipe, threads)
    spent_s = load_checkpoint(learner, recipe_file, newest_checkpoint(runs)) if resume else 0.0
    begun_s = time.monotonic() - spent_s

    def save() -> CheckpointSaved:
        folder = save_checkpoint(learner, recipe_file, runs, time.monotonic() - begun_s)
        return CheckpointSaved(learner.steps, folder)

    learner.ppo.set_logger(configure(str(runs / "tensorboard"), ["tensorboard"]))
    watcher = Watcher(learner, watch=watch, save=save, interrupted=interrupted, begun_s=begun_s)
    learner.learn(watcher)
    wall_time_s = time.monotonic() - begun_s
    if watcher.stopped and watcher.saved:
        saved = watcher.saved
        return Trained(load_policy(saved.folder), saved.folder, saved.steps, wall_time_s, True, evaluation=None)

    policy = export_policy(learner, recipe_file, out, wall_time_s)
    if not (out / RECIPE).exists() or (out / RECIPE).resolve() != recipe_file.path.resolve():
        (out / RECIPE).write_bytes(recipe_file.source)
    plan = recipe.evaluation
    evaluation = evaluate(policy, load_suite("paper"), plan.trials, plan.seed, threads, evaluating)
    write_evaluation(evaluation, out / EVALUATION)
    return Trained(policy, out, learner.steps, wall_time_s, interrupted=False, evaluation=evaluation)


def _prepare(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"the folder cannot be made: {error.strerror}", where=str(folder)) from error
    if not os.access(folder, os.W_OK):
        raise OutputError("the folder cannot be written: no permission", where=str(folder))
