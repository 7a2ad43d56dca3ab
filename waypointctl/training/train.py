"""Training from a recipe to a policy bundle with its evaluation."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from waypointctl.errors import OutputError, RecipeError, given_number, given_path
from waypointctl.evaluation.result import EVALUATION, Evaluation
from waypointctl.evaluation.saved import remove_outdated
from waypointctl.evaluation.suite import load_suite
from waypointctl.paths import refuse_unwritable_folder, write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.write import copy_bundle
from waypointctl.training.checkpoint import load_checkpoint, save_checkpoint
from waypointctl.training.evaluator import CheckpointSelector, Evaluator, final_evaluation, selection_suite
from waypointctl.training.events import CheckpointSaved, OnEvent, Resumed, Threads, TrainingEvent
from waypointctl.training.progress import TrainingLog
from waypointctl.training.recipe_file import RecipeFile, load_recipe, place_recipe, with_plugins
from waypointctl.training.recipe_references import load_recipe_to_train, load_warm_start
from waypointctl.training.run_folder import checkpoint_at, held, newest_checkpoint, require_checkpoint
from waypointctl.training.selection import Selection, with_record
from waypointctl.training.state import TrainingState

FINAL_SUITE: Final = "paper"


@dataclass(frozen=True, slots=True)
class TrainingResult:
    """The outcome of a training.

    Attributes:
        policy: loaded from `folder`.
        folder: of the bundle; the last checkpoint's if the training was interrupted.
        evaluation: on the paper's cases; None if the training was interrupted.
        steps: control steps of the training; the policy's own are fewer if an earlier checkpoint was
            selected.
        wall_time_s: of all sessions, without the evaluation.
        selection: the checkpoints that were evaluated, where the recipe has a selection.
        threads: that were used.
        already_complete: the training was resumed and was complete before.
    """

    policy: LoadedPolicy
    folder: Path
    evaluation: Evaluation | None
    steps: int
    wall_time_s: float
    selection: Selection | None
    threads: Threads
    already_complete: bool


def _ignore(event: TrainingEvent) -> None: ...


def train(
    recipe: RecipeFile | Path | str,
    out: Path | str,
    *,
    run: Path | str | None = None,
    threads: int = 0,
    resume: bool = False,
    allow_plugins: bool = False,
    on_event: OnEvent = _ignore,
    interrupted: Callable[[], bool] = lambda: False,
) -> TrainingResult:
    """Train a policy by a recipe, evaluate it on the paper's cases and write its bundle.

    An interrupted training leaves `out` as it was; its last checkpoint is a policy bundle. Resumed with as many
    threads, it ends in the weights of an uninterrupted one, bit for bit.

    Args:
        recipe: its file, or the loaded file; of that, seed and steps may have been changed.
        out: folder of the finished bundle, with its recipe and evaluation; a bundle in it is replaced.
        run: folder for checkpoints, progress and TensorBoard scalars; `out` by default.
        threads: of physics and of torch; 0 is the default, or those that the resumed run was trained with.
        resume: continue from the newest checkpoint in `run`.
        allow_plugins: execute the Python files in the recipe's `plugins`.
        on_event: called with the progress of training and evaluation.
        interrupted: called before every rollout and while evaluating; True ends the training with a checkpoint.

    Raises:
        OutputError: `out` or `run` cannot be written, or `run` has checkpoints and `resume` is False.
        RecipeError: the recipe is wrong; there is no checkpoint to resume from, or it is damaged or of another recipe;
            the training diverged; or the policy to start from does not fit the recipe.
        PolicyError, SuiteError: the policy to start from, or the suite to select by, is missing or damaged.
    """
    if not isinstance(recipe, RecipeFile):
        recipe = load_recipe(recipe) if resume else load_recipe_to_train(given_path("recipe", recipe, "a recipe file"))
    if not recipe.plugins:
        recipe = with_plugins(recipe, allowed=allow_plugins)
    out = given_path("out", out, "the policy's folder")
    run = out if run is None else given_path("run", run, "the run's folder")
    threads = given_number("threads", threads, 0, 1024)
    refuse_unwritable_folder(out)
    with held(run):
        return _trained(TrainingState(recipe, threads), run, out, resume, on_event, interrupted)


def _trained(
    state: TrainingState, run: Path, out: Path, resume: bool, on_event: OnEvent, interrupted: Callable[[], bool]
) -> TrainingResult:
    """Train to the end or to an interruption, in a run's folder that is held."""
    begun_s = time.monotonic() - _begin(state, run, resume, on_event)
    on_event(state.threads)
    evaluator = Evaluator(state.recipe_file, state.threads.physics, on_event, interrupted)
    selector = _selector(state, run, resume, evaluator, begun_s)
    selection = selector.selection if selector else None
    complete = resume and (state.steps >= state.recipe.last_step or (selection is not None and selection.met))
    if resume:
        on_event(Resumed(state.steps, state.recipe.last_step, complete))
    loop = _Loop(state, run, begun_s, selector, on_event, interrupted)
    finished = loop.run_to_end()
    wall_time_s = time.monotonic() - begun_s
    folder, policy, steps = _selected(loop, selection, run, finished)
    suite = load_suite(FINAL_SUITE)
    evaluation = final_evaluation(policy, suite, evaluator, out, complete=complete) if finished else None
    if evaluation is None:
        policy = load_policy(folder)
    else:
        _finish(policy, state.recipe_file, evaluation, out)
        folder = out
    return TrainingResult(policy, folder, evaluation, steps, wall_time_s, selection, state.threads, complete)


@dataclass(slots=True)
class _Loop:
    """The training loop, and the last checkpoint that it saved."""

    state: TrainingState
    run: Path
    begun_s: float
    selector: CheckpointSelector | None
    on_event: OnEvent
    interrupted: Callable[[], bool]
    saved: CheckpointSaved | None = None
    next_checkpoint: int = 0

    def run_to_end(self) -> bool:
        """Train until the last step, or the selection's target is met; return False if interrupted before."""
        state, learner = self.state, self.state.learner
        self._plan_checkpoint()
        with TrainingLog(self.run, state.recipe, state.steps, self.begun_s) as log:
            finished = self._target_met or self._checkpoint_and_select(log)
            while finished is None:
                state.enter_phase()
                try:
                    rollout = learner.collect()
                    metrics = learner.update()
                except ValueError:  # a number that is not finite, in the middle of an update
                    self._refuse_diverged()
                    raise
                self._refuse_diverged()
                self.on_event(log.add(state.steps, rollout, metrics))
                finished = self._checkpoint_and_select(log)
        return finished

    def _checkpoint_and_select(self, log: TrainingLog) -> bool | None:
        """Save and evaluate a checkpoint where one is due; return whether training is finished, None to continue."""
        steps = self.state.steps
        ended = steps >= self.state.recipe.last_step
        stopped = not ended and self.interrupted()
        evaluates = self.selector is not None and self.selector.selection.is_due(steps, last=ended)
        if ended or stopped or evaluates or steps >= self.next_checkpoint:
            self._checkpoint()
        if stopped:
            return False
        if evaluates and not self._select(log):
            return False
        return True if ended or self._target_met else None

    def _checkpoint(self) -> None:
        folder = save_checkpoint(self.state, self.run, time.monotonic() - self.begun_s)
        self.saved = CheckpointSaved(self.state.steps, folder)
        self._plan_checkpoint()
        self.on_event(self.saved)

    def _plan_checkpoint(self) -> None:
        every = self.state.recipe.checkpoint_steps
        self.next_checkpoint = (self.state.steps // every + 1) * every

    def _select(self, log: TrainingLog) -> bool:
        """Evaluate the checkpoint just saved; return False if that was interrupted."""
        assert self.selector is not None
        assert self.saved is not None
        candidate = self.selector.evaluate(self.saved)
        if candidate is not None:
            log.add_selection(candidate.steps, candidate.success_rate)
        return candidate is not None

    @property
    def _target_met(self) -> bool:
        return self.selector is not None and self.selector.selection.met

    def _refuse_diverged(self) -> None:
        """End a training whose network has numbers that are not finite: no update recovers from them."""
        if self.state.learner.is_finite():
            return
        last = newest_checkpoint(self.run)
        kept = f"the last checkpoint is {last}" if last else "there is no checkpoint yet"
        problem = f"the training diverged: at step {self.state.steps} the network has numbers that are not finite"
        hint = "Start a new run with a lower learning_rate, reward_scale or max_gradient."
        raise RecipeError(f"{problem}; {kept}", where=str(self.state.recipe_file.path), hint=hint)


def _begin(state: TrainingState, run: Path, resume: bool, on_event: OnEvent) -> float:
    """Return the wall time spent until now [s]."""
    if resume:
        return load_checkpoint(state, require_checkpoint(run))
    if newest_checkpoint(run):
        problem = "has the checkpoints of an earlier training"
        raise OutputError(problem, where=str(run), hint="Resume that training, or choose another folder.")
    if warm_start := load_warm_start(state.recipe_file):
        on_event(warm_start.apply(state.learner, state.recipe_file))
        state.start = warm_start.record()
    place_recipe(state.recipe_file, run)
    return 0.0


def _selector(
    state: TrainingState, run: Path, resume: bool, evaluator: Evaluator, begun_s: float
) -> CheckpointSelector | None:
    suite, plan = selection_suite(state.recipe_file, run, resume=resume), state.recipe.selection
    if suite is None or plan is None:
        return None
    return CheckpointSelector(Selection(plan, run, state.steps, suite.name), suite, evaluator, begun_s)


def _selected(loop: _Loop, selection: Selection | None, run: Path, finished: bool) -> tuple[Path, LoadedPolicy, int]:
    """Return the checkpoint that becomes the policy, the policy, and the steps that training ended at.

    It is the last one, unless there is a selection and training is finished.
    """
    if selection is None or not finished:
        assert loop.saved is not None, "every training ends with a checkpoint"
        return loop.saved.folder, load_policy(loop.saved.folder), loop.saved.steps
    folder = checkpoint_at(run, selection.best.steps)
    return folder, with_record(load_policy(folder), selection.record()), selection.last_steps


def _finish(policy: LoadedPolicy, recipe_file: RecipeFile, evaluation: Evaluation, out: Path) -> None:
    """Write the bundle to `out`, and remove the evaluations of an earlier one."""
    remove_outdated(out, policy.sha256)
    copy_bundle(policy, out)
    place_recipe(recipe_file, out)
    write_whole(out / EVALUATION, evaluation.to_json().encode(), "the evaluation")
