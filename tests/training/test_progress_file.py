from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from tests.training.tiny import ROLLOUT, ROLLOUTS, after, tiny_recipe
from waypointctl.errors import InputError
from waypointctl.training.events import TrainingEvent, TrainingStatus
from waypointctl.training.learner import Rollout
from waypointctl.training.progress import PROGRESS, ProgressRow, TrainingLog, read_progress
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import checkpoint_at
from waypointctl.training.train import train

PHASES = [{"steps": 1024}]
RECIPE = Recipe.model_validate(
    {"name": "tiny", "algorithm": {"name": "ppo", "robots": 16, "rollout_steps": 8, "minibatch": 64}, "phases": PHASES}
)
DONE = Rollout(steps=128, reward=12.8, episodes=7, successes=3, falls=2, timeouts=2, waypoints=9)


@contextmanager
def log_in(run: Path, steps: int = 0) -> Iterator[TrainingLog]:
    with TrainingLog(run, RECIPE, steps, time.monotonic()) as log:
        yield log


def row(steps: int) -> ProgressRow:
    return ProgressRow(steps, 0.0, 0, 7, 3, 2, 2, 9, 0.1, RECIPE.schedules_at(steps))


def trained_telling(recipe_file: RecipeFile, run: Path, rollouts: int | None, *, resume: bool) -> list[TrainingStatus]:
    """Train as asked; return what was told after each rollout."""
    events: list[TrainingEvent] = []
    interrupted = (lambda: False) if rollouts is None else after(rollouts)
    train(recipe_file, run, run=run, threads=1, resume=resume, interrupted=interrupted, on_event=events.append)
    return [told for told in events if isinstance(told, TrainingStatus)]


def timeless(rows: list[ProgressRow]) -> list[ProgressRow]:
    return [replace(one, wall_time_s=0.0) for one in rows]


def test_rows_come_back_as_they_were_and_are_on_disk_at_once(tmp_path: Path) -> None:
    steps = (128, 256, 384)
    with log_in(tmp_path) as log:
        for number, at in enumerate(steps):
            log.add(at, DONE, {})
            assert timeless(read_progress(tmp_path)) == [row(each) for each in steps[: number + 1]]
    lines = (tmp_path / PROGRESS).read_text().splitlines()
    names = "steps,wall_time_s,phase,episodes,successes,falls,timeouts,waypoints,mean_reward,learning_rate,entropy"
    assert (lines[0], lines[1].split(",")[3:9]) == (names, ["7", "3", "2", "2", "9", "0.1"])


@pytest.mark.parametrize("cut", [0, 1, 12, 30])
def test_rows_after_the_checkpoint_and_one_cut_short_by_a_kill_are_left_out(tmp_path: Path, cut: int) -> None:
    with log_in(tmp_path) as log:
        for steps in (128, 256, 384, 512):
            log.add(steps, DONE, {})
    path = tmp_path / PROGRESS
    path.write_bytes(path.read_bytes()[: -cut or None])
    assert len(read_progress(tmp_path)) == (4 if cut == 0 else 3)
    with log_in(tmp_path, 256) as log:
        assert timeless(read_progress(tmp_path)) == [row(128), row(256)]
        log.add(384, DONE, {})
    assert timeless(read_progress(tmp_path)) == [row(128), row(256), row(384)]
    with log_in(tmp_path):
        assert read_progress(tmp_path) == []


def test_no_file_is_no_rows_and_another_file_is_refused(tmp_path: Path) -> None:
    assert read_progress(tmp_path) == []
    for text in ("steps,phase\n1,2\n", "steps\nx\n", "{}\n[]\n"):
        (tmp_path / PROGRESS).write_text(text)
        with pytest.raises(InputError, match=r"progress\.csv: is not the progress of a training"):
            read_progress(tmp_path)
    (tmp_path / PROGRESS).write_bytes(b"\xff\n")
    with pytest.raises(InputError, match="cannot be read"):
        read_progress(tmp_path)


def test_a_training_in_pieces_tells_what_a_whole_one_does(tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path)
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    told = trained_telling(recipe_file, whole, None, resume=False)
    rows = read_progress(whole)
    assert [one.steps for one in rows] == [ROLLOUT * rollout for rollout in range(1, ROLLOUTS + 1)]
    assert all(one.episodes == one.successes + one.falls + one.timeouts for one in rows)
    assert sum(one.episodes for one in rows) == told[-1].episodes > 0

    trained_telling(recipe_file, pieces, 3, resume=False)
    trained_telling(recipe_file, pieces, None, resume=True)
    for late in (768, 1024):  # as if it had been killed before it could write them
        shutil.rmtree(checkpoint_at(pieces, late))
    retold = trained_telling(recipe_file, pieces, None, resume=True)
    assert timeless(read_progress(pieces)) == timeless(rows)
    assert len(retold) == 4
    for again, first in zip(retold, told[4:], strict=True):  # the rates look back over what earlier sessions did
        assert (again.steps, again.episodes, again.success_rate) == (first.steps, first.episodes, first.success_rate)
        assert again.mean_reward == pytest.approx(first.mean_reward, rel=1e-12)
