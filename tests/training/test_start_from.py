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

from tests.training.tiny import RECIPE, ROLLOUT, new_learner, tiny_recipe, trained, weights_of
from waypointctl.errors import PolicyError, RecipeError
from waypointctl.policy.bundle import load_policy
from waypointctl.policy.manifest import SelectionRecord
from waypointctl.policy.write import copy_bundle
from waypointctl.training.checkpoint import ARRAYS, FACTS, load_checkpoint
from waypointctl.training.export import weights
from waypointctl.training.origin import load_origin
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import newest_checkpoint
from waypointctl.training.selection import with_record
from waypointctl.training.start_from import start_from
from waypointctl.training.status import News, StartedFrom
from waypointctl.training.train import train

NOISE = RECIPE.replace("name: tiny", "name: source\nobservation: state_noise")
GOAL = RECIPE.replace("name: tiny", "name: next\nobservation: state_goal\nstart_from: ../source")


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
    learner, origin = new_learner(shelf.recipe_file), load_origin(shelf.recipe_file)
    assert origin is not None
    told = start_from(learner, origin, shelf.recipe_file)
    theirs, own = load((shelf.source / "weights.safetensors").read_bytes()), weights(learner)
    assert own.keys() == theirs.keys()
    for name in own.keys() - {"normaliser.count"}:
        assert np.array_equal(own[name], theirs[name]), name
    # 1024 steps and the 16 first observations stand behind them; from here on they count as one rollout.
    assert theirs["normaliser.count"] == pytest.approx(1040, abs=0.01)
    assert own["normaliser.count"] == ROLLOUT
    assert not learner.ppo.policy.optimizer.state_dict()["state"]
    assert told == StartedFrom(
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
    learner, origin = new_learner(recipe_file), load_origin(recipe_file)
    assert origin is not None
    told = start_from(learner, origin, recipe_file)
    assert told.others == ()
    own = weights(learner)
    for name, array in load((shelf.source / "weights.safetensors").read_bytes()).items():
        assert np.array_equal(own[name], array), name


def test_trained_and_resumed_without_the_source_it_ends_the_same_and_says_where_it_came_from(
    shelf: Shelf, tmp_path: Path
) -> None:
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    news: list[News] = []
    train(shelf.recipe_file, whole, run=whole, threads=1, watch=news.append)
    assert [told.policy for told in news if isinstance(told, StartedFrom)] == ["source"]
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
    with pytest.raises(RecipeError, match=rf"recipe\.yaml:\d+:13: start_from: policy 'source' .*: {problem}\n  Give"):
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
        message = r"start_from: .*chosen in 'region' with seed 5, .* evaluation\.seed\n  Give evaluation another seed"
        with pytest.raises(RecipeError, match=message):
            load_origin(recipe_file)
    else:
        learner, origin = new_learner(recipe_file), load_origin(recipe_file)
        assert origin is not None
        start_from(learner, origin, recipe_file)
        assert learner.start is not None
        assert learner.start.selection == record


def test_a_source_that_is_not_there_or_damaged_is_refused(shelf: Shelf, tmp_path: Path) -> None:
    with (shelf.source / "weights.safetensors").open("r+b") as file:
        file.write(b"x")
    with pytest.raises(PolicyError, match=r"weights\.safetensors: altered"):
        trained(shelf.recipe_file, tmp_path / "run")
    shutil.rmtree(shelf.source)
    with pytest.raises(PolicyError, match=r"\.\./source: no such folder"):
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
        load_origin(shelf.recipe_file)


def test_a_checkpoint_from_before_the_sources_selection_was_kept_is_read(shelf: Shelf, tmp_path: Path) -> None:
    trained(shelf.recipe_file, tmp_path / "run", rollouts=1)
    folder = newest_checkpoint(tmp_path / "run")
    assert folder is not None
    content, arrays = json.loads((folder / FACTS).read_bytes()), (folder / ARRAYS).read_bytes()

    def sha256(facts: object) -> str:
        return hashlib.sha256(json.dumps(facts, separators=(",", ":")).encode() + arrays).hexdigest()

    assert sha256(content["facts"]) == content["sha256"]
    assert content["facts"]["start"].pop("selection") is None
    (folder / FACTS).write_text(json.dumps(content | {"sha256": sha256(content["facts"])}))
    learner = new_learner(shelf.recipe_file)
    load_checkpoint(learner, shelf.recipe_file, folder)
    assert learner.start is not None
    assert (learner.start.policy, learner.start.selection) == ("source", None)


def test_without_one_there_is_none(tmp_path: Path) -> None:
    assert load_origin(tiny_recipe(tmp_path)) is None
