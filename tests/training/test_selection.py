from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.training.scores import NEAR, SELECTING, scripted
from tests.training.tiny import RECIPE, ROLLOUT, after, tiny_recipe, trained, weights_of
from waypointctl.errors import RecipeError, SuiteError
from waypointctl.evaluation.result import read_evaluation
from waypointctl.policy.bundle import load_policy
from waypointctl.training.checkpoint import begun_as
from waypointctl.training.evaluator import SUITE
from waypointctl.training.events import CheckpointEvaluated, EvaluationProgress, TrainingEvent
from waypointctl.training.recipe_file import RecipeFile, load_recipe
from waypointctl.training.run_folder import checkpoint_at
from waypointctl.training.selection import SELECTION, Candidate, Selection, SelectionRecipe
from waypointctl.training.train import train

PLAN = SelectionRecipe(suite="region", trials=10, seed=50, every=100)
UNEVEN = {384: 0.5, 640: 1.0, 1024: 0.5}  # by the steps that `every: 300` leads to, and the last


def candidate(steps: int, successes: int) -> Candidate:
    return Candidate(steps=steps, wall_time_s=1.0, trials=10, successes=successes, falls=0)


def selection_of(run: Path, *found: tuple[int, int], plan: SelectionRecipe = PLAN) -> Selection:
    selection = Selection(plan, run, 0)
    for steps, successes in found:
        selection.add(candidate(steps, successes))
    return selection


@pytest.fixture
def recipe_file(tmp_path: Path) -> RecipeFile:
    (tmp_path / "near.yaml").write_text(NEAR)
    return tiny_recipe(tmp_path, RECIPE + SELECTING)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run without a selection."""
    run = tmp_path_factory.mktemp("plain") / "run"
    trained(tiny_recipe(run.parent), run)
    return run


def test_the_most_successes_win_and_of_equals_the_later(tmp_path: Path) -> None:
    assert selection_of(tmp_path, (100, 3), (200, 9), (300, 8)).best.steps == 200
    assert selection_of(tmp_path, (100, 9), (200, 9), (300, 8)).best.steps == 200
    assert selection_of(tmp_path, (100, 0), (200, 0)).best.steps == 200


@pytest.mark.parametrize(
    ("found", "due"), [((), 100), ((100,), 200), ((130,), 200), ((199,), 200), ((200,), 300), ((130, 1250), 1300)]
)
def test_it_is_due_at_each_multiple_once(tmp_path: Path, found: tuple[int, ...], due: int) -> None:
    selection = selection_of(tmp_path, *((steps, 1) for steps in found))
    assert not selection.is_due(due - 1, last=False)
    assert selection.is_due(due, last=False)
    assert selection.is_due(due + 999, last=False)


def test_the_target_is_met_at_it_and_not_below(tmp_path: Path) -> None:
    plan = PLAN.model_copy(update={"stop_at": 0.9})
    assert not selection_of(tmp_path, plan=plan).met
    assert not selection_of(tmp_path, (100, 8), plan=plan).met
    assert selection_of(tmp_path, (100, 9), (200, 1), plan=plan).met
    assert not selection_of(tmp_path, (100, 10)).met  # there is none


def test_what_was_found_after_the_checkpoint_that_is_gone_on_from_is_forgotten(tmp_path: Path) -> None:
    selection_of(tmp_path, (100, 3), (200, 9), (300, 8))
    assert [one.steps for one in Selection(PLAN, tmp_path, 250).candidates] == [100, 200]
    assert [one.steps for one in Selection(PLAN, tmp_path, 300).candidates] == [100, 200, 300]
    assert not Selection(PLAN, tmp_path, 0).candidates
    assert not Selection(PLAN, tmp_path / "none", 300).candidates


def test_a_damaged_record_is_refused(tmp_path: Path) -> None:
    (tmp_path / SELECTION).write_text('{"suite": "region"')
    with pytest.raises(RecipeError, match=r"selection\.json: the record .* cannot be read\n  Remove the file"):
        Selection(PLAN, tmp_path, 100)


def test_the_best_checkpoint_is_the_policy_and_its_manifest_says_how_it_was_chosen(
    recipe_file: RecipeFile, plain: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    tested = scripted(monkeypatch, UNEVEN)
    run = tmp_path / "run"
    events: list[TrainingEvent] = []
    result = train(recipe_file, run, run=run, threads=1, on_event=events.append)
    assert tested == [384, 640, 1024]
    assert (result.steps, result.policy.manifest.training.steps) == (1024, 640)
    assert weights_of(run) == weights_of(checkpoint_at(run, 640)) != weights_of(checkpoint_at(run, 1024))
    record = load_policy(run).manifest.training.selection
    assert record is not None
    assert record.model_dump() == {
        "suite": "near.yaml",
        "seed": 50,
        "trials": 2,
        "successes": 2,
        "candidates": 3,
        "last_step": 1024,
        "stop_at": None,
    }
    assert read_evaluation(run / "evaluation.json").policy_sha256 == load_policy(run).sha256
    written = json.loads((run / SELECTION).read_text())
    assert written["selected_steps"] == 640
    assert [(one["steps"], one["successes"]) for one in written["candidates"]] == [(384, 1), (640, 2), (1024, 1)]
    said = [told for told in events if isinstance(told, CheckpointEvaluated)]
    assert [(told.steps, told.success_rate, told.best_steps) for told in said] == [
        (384, 0.5, 384),
        (640, 1.0, 640),
        (1024, 0.5, 640),
    ]
    assert EvaluationProgress("near", False, "ahead", 2, 2) in events
    # It has not disturbed the training, which a run without a selection shows.
    for steps in (256, 512, 768, 1024):
        assert weights_of(checkpoint_at(run, steps)) == weights_of(checkpoint_at(plain, steps))


@pytest.mark.parametrize(("asked", "to_try"), [(3, 384), (4, 384), (11, 640)])
def test_interrupted_in_training_or_in_a_test_it_chooses_the_same(
    recipe_file: RecipeFile, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, asked: int, to_try: int
) -> None:
    # Asked before rollouts 0 to 3, in the test at 384, before 4, 5, in the test at 640, before 6, 7, in the test at
    # 1024, and in the evaluation of what was chosen.
    scripted(monkeypatch, UNEVEN)
    run = tmp_path / "run"
    stopped = train(recipe_file, run, run=run, threads=1, interrupted=after(asked))
    assert stopped.evaluation is None
    assert stopped.policy.manifest.training.steps == to_try
    assert load_policy(stopped.folder).sha256 == stopped.policy.sha256
    done = train(recipe_file, run, run=run, threads=1, resume=True)
    assert done.selection is not None
    assert [one.steps for one in done.selection.candidates] == [384, 640, 1024]
    assert done.policy.manifest.training.steps == 640


def test_it_survives_a_kill_after_a_checkpoint_and_before_its_test(
    recipe_file: RecipeFile, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    tested = scripted(monkeypatch, UNEVEN)
    run = tmp_path / "run"
    trained(recipe_file, run)
    for late in (768, 1024):
        shutil.rmtree(checkpoint_at(run, late))
    record = json.loads((run / SELECTION).read_text())
    record["candidates"] = record["candidates"][:1]
    (run / SELECTION).write_text(json.dumps(record))
    tested.clear()
    done = trained(recipe_file, run, resume=True)
    assert tested == [640, 1024]
    assert done.policy.manifest.training.steps == 640


def test_training_ends_when_the_target_is_met_and_stays_ended(
    recipe_file: RecipeFile, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    tested = scripted(monkeypatch, UNEVEN)
    run = tmp_path / "run"
    asked = replace(recipe_file, recipe=recipe_file.recipe.stopping_at(0.9))
    done = trained(asked, run)
    assert done.selection is not None
    assert done.selection.met
    assert (done.steps, tested) == (640, [384, 640])
    assert done.policy.manifest.training.steps == 640
    assert not checkpoint_at(run, 768).exists()
    assert begun_as(recipe_file, run).recipe == asked.recipe
    assert trained(asked, run, resume=True).steps == 640
    assert tested == [384, 640]
    # Without the target, or with a higher one, it can still be gone on with.
    further = trained(recipe_file, run, resume=True)
    assert (further.steps, tested) == (1024, [384, 640, 1024])


def test_a_suite_of_ones_own_is_kept_in_the_run(
    recipe_file: RecipeFile, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scripted(monkeypatch, UNEVEN)
    run = tmp_path / "run"
    trained(recipe_file, run, rollouts=4)
    (tmp_path / "near.yaml").unlink()
    assert (run / SUITE).read_text() == NEAR
    assert trained(load_recipe(run / "train.yaml"), run, resume=True).policy.manifest.training.steps == 640


@pytest.mark.parametrize("suite", ["regoin", "none.yaml", "recipe.yaml"])
def test_a_suite_that_is_none_is_refused_before_training(tmp_path: Path, suite: str) -> None:
    recipe_file = tiny_recipe(tmp_path, RECIPE + f"selection: {{suite: {suite}}}\n")
    with pytest.raises(SuiteError, match=suite.split(".")[0]):
        trained(recipe_file, tmp_path / "run")
    assert not (tmp_path / "run" / "checkpoints").exists()


def test_what_is_reported_is_never_what_was_chosen_by(tmp_path: Path) -> None:
    text = RECIPE.replace("{trials: 1}", "{trials: 1, seed: 1000}")
    with pytest.raises(RecipeError, match=r"selection: the seed 1000 is also evaluation\.seed: .*; use another seed"):
        tiny_recipe(tmp_path, f"{text}selection: {{}}\n")
    with pytest.raises(
        RecipeError, match=r"selection\.seed: expected a whole number from 1 to 4294967295; got 0"
    ):  # what `eval` reports unless told
        tiny_recipe(tmp_path, f"{text}selection: {{seed: 0}}\n")
    with pytest.raises(ValueError, match=r"evaluation\.seed is 1000"):
        tiny_recipe(tmp_path, text).recipe.stopping_at(0.9)
    assert ROLLOUT == 128  # what the steps above are multiples of
