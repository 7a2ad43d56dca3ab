from __future__ import annotations

import json
from pathlib import Path

import fastjsonschema
import pytest

from tests.training.tiny import RECIPE, tiny_recipe
from waypointctl.errors import RecipeError
from waypointctl.mission.yaml_tree import read_tree
from waypointctl.training.recipe_file import load_recipe, recipe_schema

SHIPPED = sorted((Path(__file__).parents[2] / "policies").glob("*/train.yaml"))

WRONG = [
    ("fall: 50", "fall: -3", "recipe.yaml:10:76: phases[1].reward.fall: must be at least 0; got -3"),
    ("fall: 50", "fall: true", "recipe.yaml:10:76: phases[1].reward.fall: true is not a number"),
    ("fall: 50", "fall: .nan", "recipe.yaml:10:76: phases[1].reward.fall: nan is not a finite number"),
    ("fall: 50", "fal: 50", "recipe.yaml:10:70: phases[1].reward.fal: unknown key; did you mean 'fall'?"),
    ("robots: 16", "robot: 16", "recipe.yaml:7:24: algorithm.robot: unknown key; did you mean 'robots'?"),
    (
        "minibatch: 64",
        "minibatch: 60",
        "recipe.yaml:7:12: algorithm: robots x rollout_steps = 128 is not a multiple of minibatch",
    ),
    ("minibatch: 64", "minibatch: 1", "recipe.yaml:7:65: algorithm.minibatch: must be at least 2; got 1"),
    ("steps: 640", "steps: 4_000_000", "recipe.yaml:9:13: phases[0].steps: '4_000_000' is not a whole number"),
    ("steps: 640", "steps: 640.5", "recipe.yaml:9:13: phases[0].steps: 640.5 is not a whole number"),
    ("[1.0e-3, 5.0e-4]", "['1e-3', 5.0e-4]", "recipe.yaml:9:34: phases[0].learning_rate[0]: '1e-3' is not a number"),
    ("[1.0e-3, 5.0e-4]", "[1.0e-3]", "recipe.yaml:9:33: phases[0].learning_rate[1]: is missing"),
    ("[0.6 m, 1 m]", "[3 m, 1 m]", "recipe.yaml:3:42: course.leg: [3.0, 1.0] is not in order: the shortest"),
    (
        "[0.6 m, 1 m]",
        "[3 s, 1 m]",
        "recipe.yaml:3:43: course.leg[0]: '3 s' has the unit 's'; allowed are mm, cm, m, km",
    ),
    ("name: tiny", "name: ../tiny", "recipe.yaml:1:7: name: '../tiny' is not text of the form"),
    ("hidden: [16, 16]", "hidden: []", "recipe.yaml:6:19: network.hidden: has 0 entries; at least 1 are needed"),
]


@pytest.mark.parametrize(("right", "wrong", "message"), WRONG, ids=[wrong for _, wrong, _ in WRONG])
def test_what_is_wrong_is_said_with_its_place(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    assert RECIPE.count(right) == 1
    with pytest.raises(RecipeError) as caught:
        tiny_recipe(tmp_path, RECIPE.replace(right, wrong))
    assert str(caught.value).startswith(f"{tmp_path}/{message}")


def test_a_recipe_needs_a_phase(tmp_path: Path) -> None:
    with pytest.raises(RecipeError, match=r"recipe\.yaml:2:9: phases: has 0 entries; at least 1 are needed"):
        tiny_recipe(tmp_path, "name: none\nphases: []\n")
    with pytest.raises(RecipeError, match=r"recipe\.yaml:1:1: required key 'phases' is missing"):
        tiny_recipe(tmp_path, "name: none\n")


def test_everything_wrong_is_said_at_once(tmp_path: Path) -> None:
    text = RECIPE.replace("fall: 50", "fall: -3").replace("robots: 16", "robots: 0")
    with pytest.raises(
        RecipeError,
        match=r"2 problems\n.*:7:32: algorithm\.robots: expected a whole number from 1 to 65536; got 0\n.*:10:76: .*fall",  # noqa: E501
    ):
        tiny_recipe(tmp_path, text)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RecipeError, match=r"train\.yaml: there is no such file"):
        load_recipe(tmp_path / "train.yaml")


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.parent.name)
def test_every_shipped_recipe_is_one_and_fits_the_schema(path: Path) -> None:
    assert load_recipe(path).recipe.name == path.parent.name
    fastjsonschema.compile(recipe_schema())(read_tree(path.read_bytes()).data)


def test_the_schema_is_json_and_knows_both_spellings(tmp_path: Path) -> None:
    schema = recipe_schema()
    assert json.loads(json.dumps(schema, allow_nan=False)) == schema
    check = fastjsonschema.compile(schema)
    check(read_tree(RECIPE.encode()).data)
    check(read_tree(RECIPE.replace("leg: [0.6 m, 1 m]", "leg_m: [0.6, 1]").encode()).data)
    for wrong in (RECIPE.replace("first:", "frist:"), RECIPE.replace("fall: 50", "fall: -3")):
        with pytest.raises(fastjsonschema.JsonSchemaException):
            check(read_tree(wrong.encode()).data)


def test_both_spellings_are_one_recipe(tmp_path: Path) -> None:
    other = RECIPE.replace("leg: [0.6 m, 1 m]", "leg_m: [0.6, 1]").replace("first: 0.4 s", "first_s: 0.4")
    assert tiny_recipe(tmp_path).recipe == tiny_recipe(tmp_path, other).recipe
