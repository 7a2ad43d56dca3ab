"""What robots remember of the courses they failed goes on in a resumed training as if nothing had happened."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load

from tests.training.tiny import RECIPE, new_state, tiny_recipe, trained, weights_of
from waypointctl.training.checkpoint import ARRAYS, load_checkpoint
from waypointctl.training.run_folder import newest_checkpoint

# A robot gets through a dozen episodes, most of them too short for their course.
HURRIED = RECIPE.replace("first: 0.4 s", "first: 0.1 s")
COURSES = {
    "drawn": "{perimeter: disc, centre: [0 m, 0 m], radius: 2 m, count: 2, min_distance: 0.6 m}\n"
    "failure_replay: {probability: 0.5, memory: 3, tries: 2}",
    "cases": "{cases: [[[0.55, 0]], {waypoints: [[1, 1], [0, 2], [3, 0]], weight: 2}]}\n"
    "failure_replay: {probability: 0.9}",
}


def recipe_with(course: str) -> str:
    return HURRIED.replace("{perimeter: legs, count: 2, leg: [0.6 m, 1 m]}", course)


@pytest.mark.parametrize("name", COURSES)
def test_stopped_three_times_it_ends_in_the_weights_of_one_that_nobody_disturbed(name: str, tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path, recipe_with(COURSES[name]))
    whole, run = tmp_path / "whole", tmp_path / "run"
    trained(recipe_file, whole)
    for rollouts in (3, 2, 1):
        trained(recipe_file, run, rollouts=rollouts, resume=rollouts < 3)
        checkpoint = newest_checkpoint(run)
        assert checkpoint is not None
        remembered = load((checkpoint / ARRAYS).read_bytes())
        assert remembered["failed.size"].sum() > 16, "more courses than robots are remembered"
        assert (remembered["failed.current"] >= 0).any(), "some course is being walked again"
    trained(recipe_file, run, resume=True)
    assert weights_of(run) == weights_of(whole)
    plain = tiny_recipe(tmp_path, recipe_with(COURSES[name].replace("probability: 0.", "probability: 0.000")))
    trained(plain, tmp_path / "plain")
    assert weights_of(tmp_path / "plain") != weights_of(whole), "and courses walked again make another policy"


def test_a_restored_learner_remembers_every_course_and_every_stream(tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path, recipe_with(COURSES["drawn"]))
    folder = trained(recipe_file, tmp_path / "run", rollouts=4).folder
    learner = new_state(recipe_file)
    load_checkpoint(learner, folder)
    saved = {name: array for name, array in load((folder / ARRAYS).read_bytes()).items() if name.startswith("failed.")}
    assert learner.env.failed is not None
    restored = {f"failed.{name}": array for name, array in learner.env.failed.state().items()}
    assert sorted(restored) == sorted(saved)
    for name, array in saved.items():
        np.testing.assert_array_equal(restored[name], array)
