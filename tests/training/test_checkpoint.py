from __future__ import annotations

import json
import pickletools
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from safetensors.numpy import load

from tests.training.tiny import RECIPE, after, new_state, tiny_recipe, trained
from waypointctl.errors import RecipeError
from waypointctl.policy.bundle import load_policy
from waypointctl.sim.stepping import default_threads
from waypointctl.training.checkpoint import ARRAYS, FACTS, begun_as, load_checkpoint
from waypointctl.training.recipe_file import RecipeFile, load_recipe
from waypointctl.training.state import TORCH_THREADS, TrainingState
from waypointctl.training.train import train


@pytest.fixture(scope="module")
def recipe_file(tmp_path_factory: pytest.TempPathFactory) -> RecipeFile:
    return tiny_recipe(tmp_path_factory.mktemp("recipe"))


@pytest.fixture(scope="module")
def original(recipe_file: RecipeFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return trained(recipe_file, tmp_path_factory.mktemp("runs") / "run", rollouts=2).folder


@pytest.fixture
def checkpoint(original: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(original, tmp_path / "run" / "checkpoints" / original.name))


def test_it_is_a_policy_that_can_be_flown(checkpoint: Path) -> None:
    assert load_policy(checkpoint).manifest.training.steps == 256


def test_no_file_is_a_pickle(checkpoint: Path) -> None:
    files = sorted(checkpoint.iterdir())
    assert [file.name for file in files] == [
        "manifest.json",
        "policy.onnx",
        "training.json",
        "training.safetensors",
        "weights.safetensors",
    ]
    for file in files:
        content = file.read_bytes()
        assert not zipfile.is_zipfile(file)
        assert b"\x80\x02" not in content[:2]
        with pytest.raises(ValueError, match=r"."):
            list(pickletools.genops(content))
    json.loads((checkpoint / "manifest.json").read_bytes())
    json.loads((checkpoint / FACTS).read_bytes())
    assert load((checkpoint / ARRAYS).read_bytes())


def damages() -> list[tuple[str, int | None]]:
    """Return (file, place of a flipped bit; None for cutting it in half)."""
    return [(FACTS, None), (FACTS, -40), (FACTS, 200), (ARRAYS, None), (ARRAYS, 10), (ARRAYS, 20_000), (ARRAYS, -1)]


@pytest.mark.parametrize(("name", "place"), damages())
def test_damage_is_found(checkpoint: Path, recipe_file: RecipeFile, name: str, place: int | None) -> None:
    content = bytearray((checkpoint / name).read_bytes())
    if place is None:
        content = content[: len(content) // 2]
    else:
        content[place] ^= 1
    (checkpoint / name).write_bytes(content)
    with pytest.raises(RecipeError, match=r"step-0000000256: the checkpoint is damaged: .*\n  Remove the folder"):
        load_checkpoint(new_state(recipe_file), checkpoint)


@pytest.mark.parametrize("name", [FACTS, ARRAYS])
def test_a_missing_file_is_named(checkpoint: Path, recipe_file: RecipeFile, name: str) -> None:
    (checkpoint / name).unlink()
    with pytest.raises(RecipeError, match=f"{name}: there is no such file"):
        load_checkpoint(new_state(recipe_file), checkpoint)


@pytest.mark.parametrize("text", ["[]", "{}", '{"sha256": "0", "facts": {}}', "null", "\ud83d", ""])
def test_facts_of_another_shape_are_damage(checkpoint: Path, recipe_file: RecipeFile, text: str) -> None:
    (checkpoint / FACTS).write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(RecipeError, match=r"damaged: training\.json was changed"):
        begun_as(recipe_file, checkpoint.parents[1])


def test_another_recipe_is_refused_and_the_right_one_named(checkpoint: Path, tmp_path: Path) -> None:
    other = tiny_recipe(tmp_path, RECIPE.replace("gamma", "gamma") + "description: other\n")
    run = checkpoint.parents[1]
    with pytest.raises(RecipeError, match=rf"made by another recipe than .*recipe\.yaml\n  Resume with {run}/train"):
        begun_as(other, run)


def test_a_run_goes_on_as_it_began(checkpoint: Path, recipe_file: RecipeFile, tmp_path: Path) -> None:
    asked = replace(recipe_file, recipe=recipe_file.recipe.scaled_to(700).model_copy(update={"seed": 3}))
    run = tmp_path / "asked"
    trained(asked, run, rollouts=1)
    assert begun_as(recipe_file, run).recipe == asked.recipe
    for recipe, problem in (
        (asked.recipe.model_copy(update={"seed": 4}), "the run began with seed 3, not 4"),
        (recipe_file.recipe.model_copy(update={"seed": 3}), r"the run began with steps \[438, 262\], not \[640, 384\]"),
    ):
        with pytest.raises(RecipeError, match=problem):
            trained(replace(recipe_file, recipe=recipe), run, resume=True)


def test_the_copy_of_the_recipe_in_the_run_resumes_it(original: Path) -> None:
    run = original.parents[1]
    copy = load_recipe(run / "train.yaml")
    assert begun_as(copy, run).recipe == copy.recipe


def test_a_run_keeps_its_number_of_threads_of_the_network(recipe_file: RecipeFile, tmp_path: Path) -> None:
    began = train(recipe_file, tmp_path, run=tmp_path, threads=2, interrupted=after(1))
    assert (began.threads.torch, began.threads.requested) == (2, True)
    same = TrainingState(recipe_file, threads=0)
    assert same.threads.torch == torch.get_num_threads() == TORCH_THREADS
    load_checkpoint(same, began.folder)
    assert (same.threads.torch, same.threads.began, torch.get_num_threads()) == (2, 2, 2)
    assert same.threads.physics == default_threads()
    other = TrainingState(recipe_file, threads=1)
    load_checkpoint(other, began.folder)
    assert (other.threads.torch, other.threads.began, torch.get_num_threads()) == (1, 2, 1)
