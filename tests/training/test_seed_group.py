from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from tests.training.tiny import RECIPE, ROLLOUT, after, tiny_recipe, trained, weights_of
from waypointctl.errors import OutputError, RecipeError
from waypointctl.evaluation.result import read_evaluation
from waypointctl.policy.bundle import load_policy
from waypointctl.training.curves import CURVES, PICTURE
from waypointctl.training.progress import PROGRESS
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import GROUP, group_place
from waypointctl.training.seeds import (
    RESULTS,
    Spread,
    begin_group,
    compare,
    group_begun_as,
    is_complete,
    run_of,
    train_seeds,
)
from waypointctl.training.train import train

SHORT = RECIPE.replace("steps: 640", "steps: 128").replace("steps: 384", "steps: 128")


@pytest.fixture
def recipe_file(tmp_path: Path) -> RecipeFile:
    return tiny_recipe(tmp_path, SHORT)


def test_seeds_stopped_in_the_middle_are_gone_on_with_and_finished_ones_left_alone(
    recipe_file: RecipeFile, tmp_path: Path
) -> None:
    group, calls = tmp_path / "group", list[tuple[int, bool]]()
    begin_group(recipe_file, group, [3, 5, 4])

    def train_one(one: RecipeFile, run: Path, resume: bool) -> bool:
        seed = one.recipe.seed
        calls.append((seed, resume))
        interrupted = after(1) if (seed, resume) == (5, False) else lambda: False
        return train(one, run, run=run, threads=1, resume=resume, interrupted=interrupted).evaluation is not None

    assert train_seeds(recipe_file, [3, 5, 4], group, train_one, lambda: False) == [3]
    before = (run_of(group, 3) / "manifest.json").stat()
    assert train_seeds(recipe_file, [3, 5, 4], group, train_one, lambda: True) == [3]
    assert train_seeds(recipe_file, [3, 5, 4], group, train_one, lambda: False) == [3, 5, 4]
    assert calls == [(3, False), (5, False), (5, True), (4, False)]
    after_all = (run_of(group, 3) / "manifest.json").stat()
    assert (after_all.st_ino, after_all.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)
    # Each is the policy that a training of its own leads to.
    alone = replace(recipe_file, recipe=recipe_file.recipe.model_copy(update={"seed": 5}))
    trained(alone, tmp_path / "alone")
    assert weights_of(run_of(group, 5)) == weights_of(tmp_path / "alone")

    compared = compare(recipe_file, [3, 5, 4], group)
    assert [result.seed for result in compared.results] == [3, 5, 4]
    for result in compared.results:
        policy = load_policy(Path(result.run))
        assert (result.policy_sha256, result.steps, result.policy_steps) == (policy.sha256, 256, 256)
        assert policy.manifest.training.seed == result.seed
        cases = read_evaluation(Path(result.run) / "evaluation.json").cases
        assert result.trials == len(cases)  # one of each
        assert result.fall_rate == sum(case.falls for case in cases) / len(cases)
        assert (result.selection_rate, result.target_met) == (None, None)
    assert compared.spread["steps"] == Spread(256.0, 0.0, 256, 256)
    assert "selection_rate" not in compared.spread
    assert json.loads((group / RESULTS).read_text()) == json.loads(json.dumps(compared.to_dict()))
    assert (group / PICTURE).read_bytes().startswith(b"\x89PNG")
    assert len((group / CURVES).read_text().splitlines()) == 1 + 256 // ROLLOUT
    for seeds in ([3, 5], [5]):  # a curve of one is missing, or all are
        (run_of(group, 5) / PROGRESS).unlink(missing_ok=True)
        with pytest.raises(RecipeError, match=r"seed-5/progress\.csv: has no rows, .*\n  Put the file back, or remove"):
            compare(recipe_file, seeds, group)


def test_a_spread_is_that_of_a_sample() -> None:
    assert Spread.of([0.5]) == Spread(0.5, None, 0.5, 0.5)
    spread = Spread.of([0.2, 0.4, 0.9])
    assert (spread.lowest, spread.highest) == (0.2, 0.9)
    assert spread.mean == pytest.approx(0.5)
    assert spread.std == pytest.approx(((0.09 + 0.01 + 0.16) / 2) ** 0.5)


def test_a_group_goes_on_as_it_began(recipe_file: RecipeFile, tmp_path: Path) -> None:
    asked = replace(recipe_file, recipe=recipe_file.recipe.scaled_to(1000).stopping_at(0.5))
    group = tmp_path / "group"
    begin_group(asked, group, [0], threads=3)
    began, threads = group_begun_as(recipe_file, group)
    assert (began.recipe, threads) == (asked.recipe, 3)
    assert (group / "train.yaml").read_text() == SHORT
    (tmp_path / "other").mkdir()
    other = tiny_recipe(tmp_path / "other", SHORT + "description: other\n")
    with pytest.raises(RecipeError, match=rf"made by another recipe than .*\n  Resume with {group}/train\.yaml"):
        group_begun_as(other, group)
    (group / GROUP).write_text("{}")
    with pytest.raises(RecipeError, match=r"no group of trainings to continue: .*group\.json"):
        group_begun_as(recipe_file, group)


def test_a_group_that_has_begun_is_not_begun_again(recipe_file: RecipeFile, tmp_path: Path) -> None:
    (run_of(tmp_path, 1) / "checkpoints" / "step-0000000128").mkdir(parents=True)
    assert not is_complete(run_of(tmp_path, 1))
    with pytest.raises(
        OutputError, match=r"seed-1: has the checkpoints of an earlier training\n  Use --resume to continue it"
    ):
        begin_group(recipe_file, tmp_path, [0, 1])
    begin_group(recipe_file, tmp_path, [0, 2])


@pytest.mark.parametrize("taken", [GROUP, "manifest.json", "checkpoints/step-0000000128/training.json"])
def test_a_group_takes_no_other_trainings_folder(recipe_file: RecipeFile, tmp_path: Path, taken: str) -> None:
    folder = tmp_path / "taken"
    (folder / taken).parent.mkdir(parents=True)
    (folder / taken).touch()
    with pytest.raises(OutputError, match="has an earlier training or policy, whose recipe would be replaced"):
        begin_group(recipe_file, folder, [0])
    assert not (folder / "train.yaml").exists()


def test_where_a_group_is(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    taken = [group_place("ant", runs, None, resume=False) for _ in range(2)]
    assert taken == [runs / "ant-seeds", runs / "ant-seeds-2"]
    with pytest.raises(RecipeError, match=r"no group of seeds of 'ant' to continue\n  Train without --resume"):
        group_place("ant", runs, None, resume=True)
    for number, group in enumerate(taken):
        (group / GROUP).write_text("{}")
        os.utime(group / GROUP, (100 - number, 100 - number))
    assert group_place("ant", runs, None, resume=True) == taken[0]
    worked_on = run_of(taken[1], 0) / "checkpoints" / "step-0000000128"
    worked_on.mkdir(parents=True)
    assert group_place("ant", runs, None, resume=True) == taken[1]
    assert group_place("ant", runs, tmp_path / "mine", resume=True) == tmp_path / "mine"
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="this is a file"):
        group_place("ant", runs, tmp_path / "file", resume=False)
