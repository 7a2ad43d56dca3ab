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
RELENTLESS = RECIPE.replace("checkpoint_steps: 256", "checkpoint_steps: 128").replace("steps: 640", "steps: 2560")
SELECTING = "selection: {suite: near.yaml, trials: 2, seed: 50, every: 500}\n"
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
    """Train until a moment and kill; return whether it was still at it."""
    process = context.Process(target=train_in_a_process, args=(str(recipe_file.path), str(run)))
    process.start()
    assert process.pid is not None
    deadline_s = time.monotonic() + PATIENCE_S
    while not moment() and process.is_alive() and time.monotonic() < deadline_s:
        time.sleep(0.0005)
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    return process.exitcode == -signal.SIGKILL


def within_a_checkpoint(run: Path, new_at_least: int) -> Callable[[], bool]:
    """Return a moment at which a checkpoint is being written, after some new ones."""
    before = newest_checkpoint(run)

    def moment() -> bool:
        newest = newest_checkpoint(run)
        return (
            newest != before
            and newest is not None
            and half_written(run)
            and len(list(newest.parent.glob("step-*"))) >= new_at_least
        )

    return moment


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
    kills, torn = 0, 0
    for turn in range(6):
        spread_s = undisturbed.took_s / 8
        moment = within_a_checkpoint(run, turn) if turn % 2 else after_some_time(random.uniform(0.0, spread_s), run)
        kills += kill_when(context, recipe_file, run, moment)
        torn += half_written(run)
    assert kills >= 2
    assert torn >= 1  # killed in the middle of a checkpoint
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


def test_a_checkpoint_is_whole_or_not_there(
    context: ForkServerContext, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    kill_when(context, undisturbed.recipe_file, run, within_a_checkpoint(run, 2))
    for folder in (run / "checkpoints").glob("step-*"):
        load_checkpoint(Learner(undisturbed.recipe_file.recipe, 1), undisturbed.recipe_file, folder)


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
