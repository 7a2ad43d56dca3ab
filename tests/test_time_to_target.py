"""The benchmark of training time: what it counts, and that both sides do run."""

from __future__ import annotations

import json
import re
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from bench import sb3_peer, time_to_target
from bench.attempt import Attempt, Look, Stopwatch
from bench.sb3_peer import ZOO, PeerEnv
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.suite import load_suite
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import load_recipe

ROOT = Path(__file__).parents[1]
RECIPE = """\
name: tiny
course: {perimeter: legs, count: 1, leg: [0.6 m, 1 m]}
deadline: {first: 0.3 s, further: 1 s}
network: {hidden: [8]}
algorithm: {name: ppo, robots: 8, rollout_steps: 8, minibatch: 64, epochs: 1}
phases:
  - {steps: 64}
  - {steps: 64, reward: {alive: 7}}
"""
SUITE = (
    "name: near\nacceptance: {size: 2 m}\ncases: [{name: a, waypoints: [[0.1 m, 0 m]]}]\n"  # who stands there is there
)


def recipe_of(text: str, folder: Path) -> Recipe:
    (folder / "recipe.yaml").write_text(text)
    return load_recipe(folder / "recipe.yaml").recipe.stopping_at(0.95)


def attempt(*rates: float, minutes: float = 1.0) -> Attempt:
    """An attempt with a test every so many minutes and every 100,000 steps."""
    looks = (Look(100_000 * i, 60.0 * minutes * i, rate) for i, rate in enumerate(rates, 1))
    return Attempt(tuple(looks), 0.95)


def test_the_time_is_that_of_the_first_test_that_met_the_target() -> None:
    found = attempt(0.1, 0.95, 0.9, 1.0)
    assert found.reached == found.end == Look(200_000, 120.0, 0.95)
    assert found.best == 1.0


@pytest.mark.parametrize(
    ("ours", "peer", "ratio", "bound", "verdict"),
    [
        (attempt(0.5, 0.96), attempt(0.1, 0.2, 0.97, minutes=4), 6.0, False, "6 times faster"),
        (
            attempt(0.5, 0.96),
            attempt(0.3, 0.2, minutes=4),
            4.0,
            True,
            "at least 4 times faster: the peer was not there yet, its best was 30.0%",
        ),
        (attempt(0.5, 0.94), attempt(0.97), None, False, "ours did not reach the target; its best was 94.0%"),
    ],
)
def test_the_ratio_is_a_bound_where_the_peer_is_not_there_yet(
    tmp_path: Path, ours: Attempt, peer: Attempt, ratio: float | None, bound: bool, verdict: str
) -> None:
    selection = recipe_of(RECIPE, tmp_path).selection
    assert selection is not None
    found = time_to_target.summary(ours, peer, "tiny", selection, load_suite("region"))
    assert (found["times_faster"], found["lower_bound"]) == (ratio, bound)
    table = time_to_target.table(found)
    assert table.splitlines()[-1] == verdict
    assert max(len(line) for line in table.splitlines()) <= 80
    assert json.loads(json.dumps(found)) == found


@pytest.mark.parametrize(
    ("more", "options", "message"),
    [
        ("warm_start: ../other\n", "", r"recipe\.yaml: warm_start: '\.\./other' was trained in time that would not be"),
        ("evaluation: {seed: 1000}\n", "", r"recipe\.yaml: evaluation\.seed is 1000, .*\n  Give the recipe's"),
        ("", "--target 1.5", r"--target: '1\.5' is not a success rate above 0, up to 1"),
        ("", "--every 0", r"--every: '0' is not a whole number > 0"),
        ("", "--suite nowhere.yaml", r"nowhere\.yaml: there is no such file"),
    ],
)
def test_what_cannot_be_measured_is_refused_before_training(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    more: str,
    options: str,
    message: str,
) -> None:
    (tmp_path / "recipe.yaml").write_text(RECIPE + more)
    arguments = ["--recipe", f"{tmp_path}/recipe.yaml", *options.split()]
    monkeypatch.setattr(sys, "argv", ["time_to_target", *arguments])
    monkeypatch.delattr(time_to_target, "train_ours")
    with pytest.raises(SystemExit) as caught:
        time_to_target.main()
    assert caught.value.code == 2
    assert re.search(message, capsys.readouterr().err)


def test_the_stopwatch_leaves_out_pauses() -> None:
    stopwatch = Stopwatch()
    with stopwatch.pause():
        time.sleep(0.2)
    assert stopwatch.seconds < 0.1


def test_the_peer_is_paid_as_the_phase_says_from_its_next_episode_on(tmp_path: Path) -> None:
    recipe = recipe_of(RECIPE, tmp_path)
    env = PeerEnv(recipe.task(0))
    env.reset(seed=1)
    still = np.zeros(8, np.float32)
    assert env.step(still)[4]["reward_alive"] == 1.0
    env.enter(recipe.task(1))
    assert env.step(still)[4]["reward_alive"] == 1.0
    env.reset()
    assert env.step(still)[4]["reward_alive"] == 7.0


@pytest.mark.slow
def test_both_sides_train_and_are_tested_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "recipe.yaml").write_text(RECIPE)
    (tmp_path / "near.yaml").write_text(SUITE)
    for name, value in {"n_steps": 16, "batch_size": 16, "n_epochs": 1}.items():
        monkeypatch.setitem(ZOO, name, value)
    tested: list[tuple[str, int | None, int]] = []

    def noted(policy: Any, suite: Any, trials: int | None, seed: int) -> Any:
        tested.append((suite.name, trials, seed))
        return evaluate(policy, suite, trials, seed)

    monkeypatch.setattr(sb3_peer, "evaluate", noted)
    monkeypatch.setattr("waypointctl.training.train.load_suite", lambda _: load_suite(str(tmp_path / "near.yaml")))
    arguments = f"--recipe {tmp_path}/recipe.yaml --suite {tmp_path}/near.yaml --trials 3 --every 64 --threads 1 --json"
    peer = "--peer-every 32 --peer-limit 500 --peer-processes 1"
    monkeypatch.setattr(sys, "argv", ["time_to_target", *arguments.split(), *peer.split()])
    threads = torch.get_num_threads()
    try:
        time_to_target.main()
    finally:
        torch.set_num_threads(threads)
    found = json.loads(capsys.readouterr().out)
    assert [look["steps"] for look in found["ours"]["tests"]] == [64], "it stops where the target is met"
    assert [look["steps"] for look in found["peer"]["tests"]] == [32]
    assert found["ours"]["success_rate"] == found["peer"]["success_rate"] == 1.0
    assert tested == [("near", 3, 1000)]
    assert found["times_faster"] > 0
    assert not found["lower_bound"]
