"""Real processes, killed at moments nobody chose, end in the weights of one that nobody disturbed."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from tests.training.tiny import RECIPE, tiny_recipe, trained, weights_of
from waypointctl.training.run_folder import newest_checkpoint

LONGER = RECIPE.replace("steps: 640", "steps: 6400").replace("steps: 384", "steps: 3840")
PATIENCE_S = 60.0


def train_until_killed(recipe: Path, run: Path, *options: str) -> None:
    """Start a training, and kill it at a random moment after its first checkpoint that is new."""
    before = newest_checkpoint(run)
    command = [sys.executable, "-m", "waypointctl", "train", str(recipe), "--runs", str(run.parent), "--threads", "1"]
    with subprocess.Popen([*command, "--out", str(run), *options], stderr=subprocess.DEVNULL) as process:
        deadline_s = time.monotonic() + PATIENCE_S
        while newest_checkpoint(run) == before and time.monotonic() < deadline_s:
            time.sleep(0.01)
        time.sleep(random.uniform(0.0, 0.3))
        process.kill()
    assert process.returncode == -signal.SIGKILL
    assert newest_checkpoint(run) != before


def test_killed_twice_and_resumed_it_ends_in_the_same_weights(tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path, LONGER)
    run = tmp_path / "runs" / "killed"
    train_until_killed(recipe_file.path, run)
    train_until_killed(recipe_file.path, run, "--resume")
    trained(recipe_file, run, resume=True)
    trained(recipe_file, tmp_path / "whole")
    assert weights_of(run) == weights_of(tmp_path / "whole")
