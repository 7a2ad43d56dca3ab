from __future__ import annotations

import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from tests.training.tiny import ROLLOUT, ROLLOUTS, after, tiny_recipe
from waypointctl.errors import InputError
from waypointctl.training.events import TrainingEvent, TrainingStatus
from waypointctl.training.progress_file import PROGRESS, ProgressFile, ProgressRow, read_progress
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import checkpoint_at
from waypointctl.training.train import train

SCHEDULES = ("learning_rate", "entropy")


def row(steps: int) -> ProgressRow:
    return ProgressRow(steps, 0.5, 1, 7, 3, 2, 2, 9, 0.1 + 0.2, {"learning_rate": 1e-05, "entropy": 0.01})


def trained_telling(recipe_file: RecipeFile, run: Path, rollouts: int | None, *, resume: bool) -> list[TrainingStatus]:
    """Train as asked; return what was told after each rollout."""
    events: list[TrainingEvent] = []
    interrupted = (lambda: False) if rollouts is None else after(rollouts)
    train(recipe_file, run, run=run, threads=1, resume=resume, interrupted=interrupted, on_event=events.append)
    return [told for told in events if isinstance(told, TrainingStatus)]


def timeless(rows: list[ProgressRow]) -> list[ProgressRow]:
    return [replace(one, wall_time_s=0.0) for one in rows]


def test_rows_come_back_as_they_were_and_are_on_disk_at_once(tmp_path: Path) -> None:
    rows = [row(steps) for steps in (128, 256, 384)]
    with closing(ProgressFile(tmp_path, 0, SCHEDULES)) as file:
        for number, one in enumerate(rows):
            file.add(one)
            assert read_progress(tmp_path) == rows[: number + 1]
    assert (tmp_path / PROGRESS).read_text().splitlines()[:2] == [
        "steps,wall_time_s,phase,episodes,successes,falls,timeouts,waypoints,mean_reward,learning_rate,entropy",
        "128,0.5,1,7,3,2,2,9,0.30000000000000004,1e-05,0.01",
    ]


@pytest.mark.parametrize("cut", [0, 1, 12, 40])
def test_rows_after_the_checkpoint_and_one_cut_short_by_a_kill_are_left_out(tmp_path: Path, cut: int) -> None:
    with closing(ProgressFile(tmp_path, 0, SCHEDULES)) as file:
        for steps in (128, 256, 384, 512):
            file.add(row(steps))
    path = tmp_path / PROGRESS
    path.write_bytes(path.read_bytes()[: -cut or None])
    assert len(read_progress(tmp_path)) == (4 if cut == 0 else 3)
    with closing(ProgressFile(tmp_path, 256, SCHEDULES)) as file:
        assert file.rows == [row(128), row(256)]
        file.add(row(384))
    assert read_progress(tmp_path) == [row(128), row(256), row(384)]
    with closing(ProgressFile(tmp_path, 0, SCHEDULES)):
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
