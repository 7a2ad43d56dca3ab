from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator  # type: ignore[import-untyped]

from tests.training.tiny import RECIPE, ROLLOUT, after, tiny_recipe, trained, weights_of
from waypointctl.errors import OutputError, RecipeError
from waypointctl.evaluation.result import read_evaluation
from waypointctl.policy.bundle import load_policy
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import held, newest_checkpoint
from waypointctl.training.train import train


@pytest.fixture(scope="module")
def recipe_file(tmp_path_factory: pytest.TempPathFactory) -> RecipeFile:
    return tiny_recipe(tmp_path_factory.mktemp("recipe"))


@pytest.fixture(scope="module")
def whole(recipe_file: RecipeFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that nobody disturbed."""
    run = tmp_path_factory.mktemp("runs") / "whole"
    trained(recipe_file, run)
    return run


def copy_of(whole: Path, folder: Path) -> Path:
    return Path(shutil.copytree(whole, folder / "run"))


def test_a_finished_run_is_a_bundle_with_its_recipe_and_evaluation(whole: Path, recipe_file: RecipeFile) -> None:
    policy, evaluation = load_policy(whole), read_evaluation(whole / "evaluation.json")
    assert evaluation.policy_sha256 == policy.sha256
    assert {case.trials for case in evaluation.cases} == {1}
    assert (whole / "train.yaml").read_text() == RECIPE
    record = policy.manifest.training
    assert (record.seed, record.steps) == (7, 1024)
    assert record.recipe_sha256 == hashlib.sha256(RECIPE.encode()).hexdigest()
    assert policy.manifest.reward["fall"] == 50.0  # of the last phase
    assert weights_of(whole) == weights_of(whole / "checkpoints" / "step-0000001024")
    assert not list(whole.rglob("*.tmp"))


def test_the_same_recipe_and_seed_give_the_same_bytes(whole: Path, recipe_file: RecipeFile, tmp_path: Path) -> None:
    trained(recipe_file, tmp_path / "again")
    assert weights_of(tmp_path / "again") == weights_of(whole)
    assert (tmp_path / "again" / "policy.onnx").read_bytes() == (whole / "policy.onnx").read_bytes()


def test_another_seed_gives_other_weights_and_is_recorded(whole: Path, recipe_file: RecipeFile, tmp_path: Path) -> None:
    other = replace(recipe_file, recipe=recipe_file.recipe.model_copy(update={"seed": 8}))
    policy = trained(other, tmp_path / "other", rollouts=2).policy
    first = whole / "checkpoints" / "step-0000000256"
    assert weights_of(tmp_path / "other" / "checkpoints" / first.name) != weights_of(first)
    record = policy.manifest.training
    assert (record.seed, record.recipe_sha256) == (8, recipe_file.sha256)


@pytest.mark.parametrize("rollouts", [0, 5, 8])
def test_stopped_anywhere_and_resumed_it_ends_in_the_same_weights(
    rollouts: int, whole: Path, recipe_file: RecipeFile, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    stopped = trained(recipe_file, run, rollouts=rollouts)
    assert stopped.evaluation is None
    assert stopped.folder == run / "checkpoints" / f"step-{rollouts * ROLLOUT:010d}"
    assert stopped.policy.manifest.training.steps == rollouts * ROLLOUT
    assert not (run / "manifest.json").exists()
    assert trained(recipe_file, run, resume=True).folder == run
    assert weights_of(run) == weights_of(whole)


def test_stopped_at_every_rollout_it_still_ends_in_the_same_weights(
    whole: Path, recipe_file: RecipeFile, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    trained(recipe_file, run, rollouts=0)
    for _ in range(7):
        assert trained(recipe_file, run, rollouts=1, resume=True).evaluation is None
    trained(recipe_file, run, resume=True)
    assert weights_of(run) == weights_of(whole)


def test_an_interrupted_evaluation_leaves_the_old_policy_and_can_be_resumed(
    whole: Path, recipe_file: RecipeFile, tmp_path: Path
) -> None:
    run, out = tmp_path / "run", tmp_path / "out"
    out.mkdir()
    (out / "evaluation.json").write_text("of the policy before")
    interrupted = after(8)  # asked once a rollout, and then by the evaluation
    stopped = train(recipe_file, out, run=run, threads=1, interrupted=interrupted)
    assert (stopped.evaluation, stopped.policy.manifest.training.steps) == (None, 1024)
    assert [path.name for path in out.iterdir()] == ["evaluation.json"]
    train(recipe_file, out, run=run, threads=1, resume=True)
    assert sorted(path.name for path in out.iterdir()) == [
        "evaluation.json",
        "manifest.json",
        "policy.onnx",
        "train.yaml",
        "weights.safetensors",
    ]
    assert weights_of(out) == weights_of(whole)
    assert read_evaluation(out / "evaluation.json").policy_sha256 == load_policy(out).sha256


def test_the_recipe_beside_the_policy_is_left_alone_if_it_is_the_one_in_use(tmp_path: Path) -> None:
    out = tmp_path / "policy"
    out.mkdir()
    recipe_file = tiny_recipe(out)
    (out / "train.yaml").hardlink_to(recipe_file.path)
    before = (out / "train.yaml").stat().st_ino
    train(recipe_file, out, run=tmp_path / "run", threads=1)
    assert (out / "train.yaml").stat().st_ino == before


def test_a_run_that_has_begun_is_not_begun_again(whole: Path, recipe_file: RecipeFile) -> None:
    with pytest.raises(OutputError, match="has the checkpoints of an earlier training"):
        trained(recipe_file, whole)


def test_nothing_to_resume_from(recipe_file: RecipeFile, tmp_path: Path) -> None:
    with pytest.raises(RecipeError, match="no checkpoint to resume from"):
        trained(recipe_file, tmp_path / "run", resume=True)


def test_two_trainings_do_not_write_one_run(recipe_file: RecipeFile, tmp_path: Path) -> None:
    with held(tmp_path / "run"), pytest.raises(OutputError, match="another training is writing this run"):
        trained(recipe_file, tmp_path / "run")


def test_what_a_killed_training_left_half_written_is_cleared(
    recipe_file: RecipeFile, whole: Path, tmp_path: Path
) -> None:
    run = copy_of(whole, tmp_path)
    half = run / "checkpoints" / ".step-0000002000.1.tmp"
    half.mkdir()
    assert newest_checkpoint(run) == run / "checkpoints" / "step-0000001024"
    trained(recipe_file, run, resume=True)
    assert not half.exists()


def test_the_scalars_are_there_each_step_once_though_a_session_was_killed(
    recipe_file: RecipeFile, whole: Path, tmp_path: Path
) -> None:
    run = copy_of(whole, tmp_path)
    for late in ("step-0000000768", "step-0000001024"):  # as if it had been killed before it could write them
        shutil.rmtree(run / "checkpoints" / late)
    trained(recipe_file, run, resume=True)
    events = EventAccumulator(str(run / "tensorboard"))
    events.Reload()
    tags = set(events.Tags()["scalars"])
    wanted = {"task/mean_reward", "time/steps_per_s", "train/phase", "train/learning_rate", "train/approx_kl"}
    assert wanted <= tags
    assert {"task/success_rate", "task/fall_rate", "task/timeout_rate"} <= tags
    steps = [event.step for event in events.Scalars("train/phase")]
    assert steps == [ROLLOUT * rollout for rollout in range(1, 9)]
    assert [event.value for event in events.Scalars("train/phase")] == [0, 0, 0, 0, 1, 1, 1, 1]
    rates = [event.value for event in events.Scalars("train/learning_rate")]
    assert rates == pytest.approx([recipe_file.recipe.schedules_at(step)["learning_rate"] for step in steps], rel=1e-5)


def test_out_that_is_a_file_is_refused_before_training(recipe_file: RecipeFile, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for out, problem in ((tmp_path / "file", "this is a file"), (tmp_path / "file" / "x", "file' is a file")):
        with pytest.raises(OutputError, match=problem):
            train(recipe_file, out, run=tmp_path / "run", threads=1)
    assert not (tmp_path / "run").exists()


def test_the_evaluation_file_is_the_json_of_eval(whole: Path) -> None:
    found = json.loads((whole / "evaluation.json").read_text())
    assert [case["name"] for case in found["cases"]][:2] == ["to-10-10", "to-14-14"]
