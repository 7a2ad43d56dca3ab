"""Training a user's robot: its recipe names a folder, and the run keeps the robot beside the recipe."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.robots.folders import write_folder
from tests.robots.test_users_robot import beetle
from tests.training.tiny import RECIPE, tiny_recipe, trained
from waypointctl.errors import RecipeError
from waypointctl.training.recipe_file import load_recipe
from waypointctl.training.recipe_references import load_recipe_to_train


def test_a_run_and_its_policy_keep_the_robot_and_go_on_without_its_folder(tmp_path: Path) -> None:
    robots = write_folder(tmp_path / "robots" / "beetle", beetle()).parent
    asked, run = tiny_recipe(tmp_path, f"{RECIPE}robot: ./robots/beetle\n"), tmp_path / "run"
    trained(asked, run, rollouts=3)
    assert (run / "robot" / "mjcf" / "beetle.xml").read_bytes() == beetle()["mjcf/beetle.xml"]
    robots.rename(tmp_path / "away")
    copy = load_recipe(run / "train.yaml")
    assert copy.recipe.robot == asked.recipe.robot
    policy = trained(copy, run, resume=True).policy
    assert policy.manifest.robot == "beetle"
    assert policy.manifest.action.meaning.startswith("position_target of *")


def test_a_run_does_not_go_on_with_a_robot_that_was_changed(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "robots" / "beetle", beetle())
    asked, run = tiny_recipe(tmp_path, f"{RECIPE}robot: ./robots/beetle\n"), tmp_path / "run"
    trained(asked, run, rollouts=1)
    (folder / "robot.yaml").write_bytes(beetle()["robot.yaml"] + b"# another\n")
    with pytest.raises(RecipeError, match="robot"):
        trained(asked, run, resume=True)


@pytest.mark.parametrize(
    ("named", "more", "problem"),
    [
        ("atn", "", "recipe.yaml:13:8: robot: there is no robot 'atn'; there are: ant; did you mean 'ant'?"),
        ("robots/bee", "", "recipe.yaml:13:8: robot: "),
        ("robots/beetle", "domain_randomization: {latency: [0 ms, 3 ms]}\n", "whole number"),
    ],
)
def test_a_robot_that_cannot_be_trained_is_refused_with_its_place(
    tmp_path: Path, named: str, more: str, problem: str
) -> None:
    write_folder(tmp_path / "robots" / "beetle", beetle())
    path = tmp_path / "recipe.yaml"
    path.write_text(f"{RECIPE}robot: {named}\n{more}")
    with pytest.raises(RecipeError) as caught:
        load_recipe_to_train(path)
    assert problem in str(caught.value)
