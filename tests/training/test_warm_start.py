from __future__ import annotations

import hashlib
import json
import shutil
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load

from tests.training.tiny import RECIPE, ROLLOUT, new_state, ppo_of, tiny_recipe, trained, weights_of
from waypointctl.errors import PolicyError, RecipeError
from waypointctl.policy.bundle import load_policy
from waypointctl.policy.manifest import SelectionRecord
from waypointctl.policy.write import copy_bundle
from waypointctl.training.events import TrainingEvent, WarmStarted
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.recipe_references import load_warm_start
from waypointctl.training.selection import with_record
from waypointctl.training.train import train

NOISE = RECIPE.replace("name: tiny", "name: source\nobservation: state_noise")
GOAL = RECIPE.replace("name: tiny", "name: next\nobservation: state_goal\nwarm_start: ../source")


@dataclass(frozen=True)
class Shelf:
    """A folder of policies: `source`, trained, and beside it one that starts from it."""

    source: Path
    recipe_file: RecipeFile


@pytest.fixture(scope="module")
def trained_source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = tmp_path_factory.mktemp("shelf") / "source"
    source.mkdir()
    trained(tiny_recipe(source, NOISE), source)
    return source


@pytest.fixture
def shelf(trained_source: Path, tmp_path: Path) -> Shelf:
    source = Path(shutil.copytree(trained_source, tmp_path / "source"))
    (tmp_path / "next").mkdir()
    return Shelf(source, tiny_recipe(tmp_path / "next", GOAL))


def test_the_first_weights_are_the_sources_in_another_layout(shelf: Shelf) -> None:
    learner, warm_start = ppo_of(new_state(shelf.recipe_file)), load_warm_start(shelf.recipe_file)
    assert warm_start is not None
    event = warm_start.apply(learner, shelf.recipe_file)
    theirs, own = load((shelf.source / "weights.safetensors").read_bytes()), learner.export().weights
    assert own.keys() == theirs.keys()
    for name in own.keys() - {"normaliser.count"}:
        assert np.array_equal(own[name], theirs[name]), name
    # 1024 steps and the 16 first observations stand behind them; from here on they count as one rollout.
    assert theirs["normaliser.count"] == pytest.approx(1040, abs=0.01)
    assert own["normaliser.count"] == ROLLOUT
    assert not learner.ppo.policy.optimizer.state_dict()["state"]
    assert event == WarmStarted(
        "source",
        "state_noise",
        "state_goal",
        (
            ("noise.0", "current.x"),
            ("noise.1", "current.y"),
            ("noise.2", "next.x"),
            ("noise.3", "next.y"),
        ),
    )


def test_in_the_same_layout_the_normaliser_goes_on_as_it_was(shelf: Shelf) -> None:
    recipe_file = tiny_recipe(shelf.recipe_file.path.parent, GOAL.replace("state_goal", "state_noise"))
    learner, warm_start = ppo_of(new_state(recipe_file)), load_warm_start(recipe_file)
    assert warm_start is not None
    assert warm_start.apply(learner, recipe_file).changed == ()
    own = learner.export().weights
    for name, array in load((shelf.source / "weights.safetensors").read_bytes()).items():
        assert np.array_equal(own[name], array), name


def test_trained_and_resumed_without_the_source_it_ends_the_same_and_says_where_it_came_from(
    shelf: Shelf, tmp_path: Path
) -> None:
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    events: list[TrainingEvent] = []
    train(shelf.recipe_file, whole, run=whole, threads=1, on_event=events.append)
    assert [told.policy for told in events if isinstance(told, WarmStarted)] == ["source"]
    trained(shelf.recipe_file, pieces, rollouts=3)
    sha256 = load_policy(shelf.source).sha256
    weights_sha256 = hashlib.sha256((shelf.source / "weights.safetensors").read_bytes()).hexdigest()
    shutil.rmtree(shelf.source)
    trained(shelf.recipe_file, pieces, resume=True)
    assert weights_of(pieces) == weights_of(whole)
    for run in (whole, pieces):
        start = load_policy(run).manifest.training.start
        assert start is not None
        assert start.model_dump() == {
            "policy": "source",
            "observation": "state_noise",
            "steps": 1024,
            "policy_sha256": sha256,
            "weights_sha256": weights_sha256,
            "selection": None,
        }


@pytest.mark.parametrize(
    ("right", "wrong", "problem"),
    [
        ("hidden: [16, 16]", "hidden: [16, 8]", r"its hidden layers are \[16, 16\], the recipe's \[16, 8\]"),
        ("hidden: [16, 16]", "hidden: [16]", r"its hidden layers are \[16, 16\], the recipe's \[16\]"),
        ("16, 16]}", "16, 16], activation: tanh}", "its activation is elu, the recipe's tanh"),
        ("state_goal", "state", "its observation size is 29, the recipe's 25"),
        ("state_goal", "egocentric", "its observation size is 29, the recipe's 31"),
    ],
)
def test_another_kind_of_policy_is_refused_before_anything_is_written(
    shelf: Shelf, tmp_path: Path, right: str, wrong: str, problem: str
) -> None:
    recipe_file = tiny_recipe(shelf.recipe_file.path.parent, GOAL.replace(right, wrong))
    with pytest.raises(RecipeError, match=rf"recipe\.yaml:\d+:13: warm_start: .*'source': {problem}\n  Give"):
        trained(recipe_file, tmp_path / "run")
    assert not (tmp_path / "run" / "train.yaml").exists()


@pytest.mark.parametrize(("seed", "refused"), [(5, True), (6, False)])
def test_a_source_that_was_chosen_with_the_seed_of_the_evaluation_is_refused(
    shelf: Shelf, seed: int, refused: bool
) -> None:
    source = load_policy(shelf.source)
    record = SelectionRecord(
        suite="region", seed=seed, trials=2, successes=1, candidates=1, last_step=1024, stop_at=None
    )
    copy_bundle(with_record(source, record), shelf.source)
    recipe_file = tiny_recipe(shelf.recipe_file.path.parent, GOAL.replace("{trials: 1}", "{trials: 1, seed: 5}"))
    if refused:
        message = r"warm_start: .*selected in 'region' with seed 5, .* evaluation\.seed\n  Give evaluation"
        with pytest.raises(RecipeError, match=message):
            load_warm_start(recipe_file)
    else:
        warm_start = load_warm_start(recipe_file)
        assert warm_start is not None
        assert warm_start.record().selection == record


def test_a_source_that_is_not_there_or_damaged_is_refused(shelf: Shelf, tmp_path: Path) -> None:
    with (shelf.source / "weights.safetensors").open("r+b") as file:
        file.write(b"x")
    with pytest.raises(PolicyError, match=r"weights\.safetensors: altered"):
        trained(shelf.recipe_file, tmp_path / "run")
    shutil.rmtree(shelf.source)
    with pytest.raises(PolicyError, match=r"\.\./source: folder not found"):
        trained(shelf.recipe_file, tmp_path / "run")


@pytest.mark.parametrize(
    ("kind", "content", "message"),
    [
        ("F8_E4M3", bytes(4), "cannot be read: 'F8_E4M3'"),
        ("BF16", bytes(8), "cannot be read: 'BF16'"),
        ("F32", struct.pack("<4f", 0, 0, float("nan"), 0), "cannot be used: a is not an array of finite numbers"),
        ("I32", bytes(16), "cannot be used: a is not an array of finite numbers"),
        ("C64", bytes(32), "cannot be used: a is not an array of finite numbers"),
    ],
)
def test_weights_that_are_not_plain_numbers_are_refused(shelf: Shelf, kind: str, content: bytes, message: str) -> None:
    header = json.dumps({"a": {"dtype": kind, "shape": [4], "data_offsets": [0, len(content)]}}).encode()
    weights = struct.pack("<Q", len(header)) + header + content
    (shelf.source / "weights.safetensors").write_bytes(weights)
    manifest = json.loads((shelf.source / "manifest.json").read_bytes())
    manifest["files"]["weights.safetensors"] = {"sha256": hashlib.sha256(weights).hexdigest(), "size": len(weights)}
    (shelf.source / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(RecipeError, match=f"weights.safetensors: the weights {message}"):
        load_warm_start(shelf.recipe_file)


def test_without_one_there_is_none(tmp_path: Path) -> None:
    assert load_warm_start(tiny_recipe(tmp_path)) is None
