"""Real processes, killed at moments nobody chose, end in the weights of one that nobody disturbed."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from multiprocessing.context import ForkServerContext
from pathlib import Path

import pytest

from tests.training.scores import NEAR
from tests.training.tiny import RECIPE, tiny_recipe, trained, weights_of
from waypointctl.training.checkpoint import load_checkpoint
from waypointctl.training.progress import read_progress
from waypointctl.training.recipe_file import RecipeFile, load_recipe
from waypointctl.training.run_folder import newest_checkpoint
from waypointctl.training.selection import SELECTION, SelectionFile
from waypointctl.training.state import TrainingState

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
    cpu_s: float  # of processor time that it took


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Undisturbed:
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "near.yaml").write_text(NEAR)
    recipe_file = tiny_recipe(folder, RELENTLESS + SELECTING)
    begun_s = time.process_time()
    trained(recipe_file, folder / "run")
    return Undisturbed(recipe_file, folder / "run", time.process_time() - begun_s)


def train_until_killed(path: str, run: str, cpu_s: float | None, at_write: int | None) -> None:
    """Begin the training, or go on with it where there is a checkpoint.

    Args:
        path: of the recipe.
        run: the run's folder.
        cpu_s: of processor time after which the system ends this process, wherever it is.
        at_write: which of the checkpoints' files written from here on is left half written by a kill.
    """
    if cpu_s is not None:
        signal.setitimer(signal.ITIMER_PROF, cpu_s)  # without a handler SIGPROF ends the process, as SIGKILL does
    if at_write is not None:
        kill_within_file(at_write)
    trained(load_recipe(Path(path)), Path(run), resume=newest_checkpoint(Path(run)) is not None)


def kill_within_file(number: int) -> None:
    write, written = Path.write_bytes, [0]

    def write_and_die(path: Path, content: bytes) -> int:
        written[0] += "checkpoints" in path.parts
        if written[0] == number and "checkpoints" in path.parts:
            write(path, content[: len(content) // 2])
            os.kill(os.getpid(), signal.SIGKILL)
        return write(path, content)

    Path.write_bytes = write_and_die  # type: ignore[assignment, method-assign]


def half_written(run: Path) -> bool:
    return any((run / "checkpoints").glob(".*.tmp"))


def killed(
    context: ForkServerContext, file: RecipeFile, run: Path, *, cpu_s: float | None = None, at_write: int | None = None
) -> int | None:
    """Train in a process of its own that is killed; return its exit code."""
    process = context.Process(target=train_until_killed, args=(str(file.path), str(run), cpu_s, at_write))
    process.start()
    process.join(PATIENCE_S)
    return process.exitcode


def test_killed_at_random_moments_and_within_checkpoints_it_ends_the_same(
    context: ForkServerContext, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    run, recipe_file = tmp_path / "run", undisturbed.recipe_file
    assert killed(context, recipe_file, run, at_write=random.randint(1, 9)) == -signal.SIGKILL
    assert half_written(run)
    cpu_s = random.uniform(0.01, undisturbed.cpu_s / 2)
    assert killed(context, recipe_file, run, cpu_s=cpu_s) in (-signal.SIGPROF, 0)
    for checkpoint in (run / "checkpoints").glob("step-*"):  # whole, or not there
        load_checkpoint(TrainingState(recipe_file, 1), checkpoint)
    trained(recipe_file, run, resume=newest_checkpoint(run) is not None)
    whole = undisturbed.run
    assert weights_of(run) == weights_of(whole)
    assert chosen(run) == chosen(whole)
    assert rows(run) == rows(whole)
    assert not half_written(run)


def chosen(run: Path) -> tuple[int, list[tuple[int, int]]]:
    found = SelectionFile.model_validate_json((run / SELECTION).read_bytes())
    return found.selected_steps, [(one.steps, one.successes) for one in found.candidates]


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
        deadline_s = time.monotonic() + PATIENCE_S
        while newest_checkpoint(tmp_path / "third") is None and time.monotonic() < deadline_s:
            time.sleep(0.001)
        time.sleep(random.uniform(0.0, 0.3))
        third.kill()
    with begin("third", "--resume") as third:
        assert third.wait() == 0
    assert weights_of(tmp_path / "third") == weights_of(tmp_path / "first")
