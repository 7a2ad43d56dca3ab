"""Real processes, killed at moments nobody chose, end in the weights of one that nobody disturbed."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.context import ForkServerContext
from pathlib import Path

import pytest

from tests.training.scores import NEAR
from tests.training.tiny import RECIPE, tiny_recipe, trained, weights_of
from waypointctl.training.checkpoint import load_checkpoint
from waypointctl.training.learner import Learner
from waypointctl.training.progress_file import read_progress
from waypointctl.training.recipe_file import RecipeFile, load_recipe
from waypointctl.training.run_folder import newest_checkpoint
from waypointctl.training.selection import SELECTION, SelectionFile

# A checkpoint after every rollout, so that most of the time is spent on writing them, and many tests of them.
RELENTLESS = RECIPE.replace("checkpoint_steps: 256", "checkpoint_steps: 128")
SELECTING = "selection: {suite: near.yaml, trials: 2, seed: 50, every: 300}\n"
PATIENCE_S = 300.0  # only a machine with much else to do needs more than a few


@pytest.fixture(scope="module")
def context() -> ForkServerContext:
    """A server that has torch loaded and forks the processes to be killed, which then need no seconds to begin."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tests.training.tiny"])
    return context


@dataclass(frozen=True)
class Undisturbed:
    recipe_file: RecipeFile
    run: Path
    took_s: float


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Undisturbed:
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "near.yaml").write_text(NEAR)
    recipe_file = tiny_recipe(folder, RELENTLESS + SELECTING)
    begun_s = time.monotonic()
    trained(recipe_file, folder / "run")
    return Undisturbed(recipe_file, folder / "run", time.monotonic() - begun_s)


def train_in_a_process(path: str, run: str) -> None:
    """Begin the training, or go on with it where there is a checkpoint; its last evaluation is not part of this."""
    trained(load_recipe(Path(path)), Path(run), rollouts=10_000, resume=newest_checkpoint(Path(run)) is not None)


def half_written(run: Path) -> bool:
    return any((run / "checkpoints").glob(".*.tmp"))


def kill_when(context: ForkServerContext, recipe_file: RecipeFile, run: Path, moment: Callable[[], bool]) -> bool:
    """Train until a moment and kill there; return whether the training was still at it.

    The process is stopped before the moment is looked for once more, so that it cannot have passed.
    """
    process = context.Process(target=train_in_a_process, args=(str(recipe_file.path), str(run)))
    process.start()
    assert process.pid is not None
    deadline_s = time.monotonic() + PATIENCE_S
    while process.is_alive() and time.monotonic() < deadline_s:
        if moment():
            os.kill(process.pid, signal.SIGSTOP)
            if moment():
                break
            os.kill(process.pid, signal.SIGCONT)
        time.sleep(0.0005)
    process.kill()
    process.join()
    return process.exitcode == -signal.SIGKILL


def within_a_checkpoint(run: Path) -> Callable[[], bool]:
    """Return a moment at which a checkpoint is being written, after a new one."""
    before = newest_checkpoint(run)
    return lambda: newest_checkpoint(run) != before and half_written(run)


def after_some_time(time_s: float, run: Path) -> Callable[[], bool]:
    """Return a moment that long after the run's next checkpoint."""
    before, seen_s = newest_checkpoint(run), [float("inf")]

    def moment() -> bool:
        if newest_checkpoint(run) != before:
            seen_s[0] = min(seen_s[0], time.monotonic())
        return time.monotonic() > seen_s[0] + time_s

    return moment


def test_killed_at_random_moments_and_within_checkpoints_it_ends_the_same(
    context: ForkServerContext, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    run, recipe_file = tmp_path / "run", undisturbed.recipe_file
    for turn in range(4):
        is_torn = turn % 2 == 1
        random_s = random.uniform(0.0, undisturbed.took_s / 8)
        moment = within_a_checkpoint(run) if is_torn else after_some_time(random_s, run)
        assert kill_when(context, recipe_file, run, moment) or not is_torn
        assert half_written(run) or not is_torn
    for checkpoint in (run / "checkpoints").glob("step-*"):  # whole, or not there
        load_checkpoint(Learner(recipe_file.recipe, 1), recipe_file, checkpoint)
    trained(recipe_file, run, resume=True)
    whole = undisturbed.run
    assert weights_of(run) == weights_of(whole)
    assert chosen(run) == chosen(whole)
    assert rows(run) == rows(whole)
    assert not half_written(run)


def chosen(run: Path) -> tuple[int, list[tuple[int, int]]]:
    found = SelectionFile.model_validate_json((run / SELECTION).read_bytes())
    return found.chosen_steps, [(one.steps, one.successes) for one in found.candidates]


def rows(run: Path) -> list[tuple[int, int, int, float]]:
    return [(row.steps, row.episodes, row.successes, row.mean_reward) for row in read_progress(run)]


@pytest.mark.slow
def test_two_fresh_processes_end_in_the_same_weights_and_a_killed_third_one_too(tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path)
    command = [sys.executable, "-m", "waypointctl", "train", str(recipe_file.path), "--threads", "1"]

    def begin(run: str, *options: str) -> subprocess.Popen[bytes]:
        folder = ["--runs", str(tmp_path), "--out", str(tmp_path / run), *options]
        environment = os.environ | {"PYTHONHASHSEED": str(random.randrange(2**32))}
        return subprocess.Popen(
            [*command, *folder], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=environment
        )

    with begin("first") as first, begin("second") as second:
        assert (first.wait(), second.wait()) == (0, 0)
    assert weights_of(tmp_path / "first") == weights_of(tmp_path / "second")
    with begin("third") as third:
        moment, deadline_s = (
            after_some_time(random.uniform(0.0, 0.3), tmp_path / "third"),
            time.monotonic() + PATIENCE_S,
        )
        while not moment() and time.monotonic() < deadline_s:
            time.sleep(0.001)
        third.kill()
    with begin("third", "--resume") as third:
        assert third.wait() == 0
    assert weights_of(tmp_path / "third") == weights_of(tmp_path / "first")
