"""Training with robots that differ: stopped and resumed it ends in the same weights, and not in those without."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load

from tests.training.test_recipe_randomization import BARE
from tests.training.tiny import RECIPE, new_state, tiny_recipe, trained, weights_of
from waypointctl.training.checkpoint import ARRAYS, load_checkpoint
from waypointctl.training.run_folder import newest_checkpoint

ONE_BY_ONE = {
    "latency": "domain_randomization: {latency: [0 ms, 40 ms]}\n",
    "bodies": "domain_randomization: {mass_factor: [0.5, 2], "
    "friction_factor: [0.5, 1.5], gravity_mps2: [1.62, 9.81]}\n",
    "sensors": "domain_randomization: {sensor_noise: {joint_angle: 1 deg, gyroscope_radps: 0.5}}\n",
    "all": BARE,
}
KEPT = {
    "latency": {"drawn", "streams", "commanded"},
    "bodies": {"drawn", "streams"},
    "sensors": {"sensors"},
    "all": {"drawn", "streams", "commanded", "sensors"},
}


def test_stopped_and_resumed_it_ends_in_the_same_weights(tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path, RECIPE + BARE)
    for rollouts, resume in ((2, False), (2, True)):
        stopped = trained(recipe_file, tmp_path / "stopped", rollouts=rollouts, resume=resume).folder
    whole = trained(recipe_file, tmp_path / "whole", rollouts=4).folder
    plain = trained(tiny_recipe(tmp_path), tmp_path / "plain", rollouts=4).folder
    assert weights_of(stopped) == weights_of(whole)
    assert weights_of(whole) != weights_of(plain)


@pytest.mark.parametrize("option", [None, *ONE_BY_ONE])
def test_a_checkpoint_holds_what_varies_and_nothing_where_nothing_does(tmp_path: Path, option: str | None) -> None:
    recipe_file = tiny_recipe(tmp_path, RECIPE + ONE_BY_ONE.get(option or "", ""))
    checkpoint = trained(recipe_file, tmp_path / "run", rollouts=2).folder
    arrays = load((checkpoint / ARRAYS).read_bytes())
    kept = {name.removeprefix("randomized.") for name in arrays if name.startswith("randomized.")}
    assert kept == KEPT.get(option or "", set())


def test_a_learner_loaded_from_a_checkpoint_has_robots_that_go_and_see_alike(tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path, RECIPE + BARE)
    checkpoint = trained(recipe_file, tmp_path / "run", rollouts=2).folder
    learners = [new_state(recipe_file) for _ in range(2)]
    for learner in learners:
        load_checkpoint(learner, checkpoint)
    rng = np.random.default_rng(0)
    for _ in range(40):
        action = rng.uniform(-1, 1, (16, 8))
        first, second = (learner.env.step(action) for learner in learners)
        np.testing.assert_array_equal(first.observation, second.observation)
        np.testing.assert_array_equal(first.terms, second.terms)
    assert (learners[0].env.randomized.state()["drawn"] > 0).all()


PATIENCE_S = 300.0  # only a machine with much else to do needs more than a few


@pytest.mark.slow  # test_killed_training.py has the same without variation
def test_killed_and_resumed_it_ends_in_the_same_weights(tmp_path: Path) -> None:
    text = RECIPE.replace("steps: 640", "steps: 3200").replace("steps: 384", "steps: 1920")
    recipe_file = tiny_recipe(tmp_path, text + BARE)
    run = tmp_path / "runs" / "killed"
    command = [sys.executable, "-m", "waypointctl", "train", str(recipe_file.path), "--runs", str(run.parent)]
    with subprocess.Popen([*command, "--threads", "1", "--out", str(run)], stderr=subprocess.DEVNULL) as process:
        deadline_s = time.monotonic() + PATIENCE_S
        while newest_checkpoint(run) is None and time.monotonic() < deadline_s:
            time.sleep(0.01)
        time.sleep(random.uniform(0.0, 0.3))
        process.kill()
    assert process.returncode == -signal.SIGKILL
    assert newest_checkpoint(run) is not None
    trained(recipe_file, run, resume=True)
    trained(recipe_file, tmp_path / "whole")
    assert weights_of(run) == weights_of(tmp_path / "whole")
