"""What a recipe refers to is looked for before training, and told with all else that is wrong with the file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.training.scores import NEAR
from tests.training.tiny import RECIPE, tiny_recipe
from waypointctl.errors import RecipeError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import SelectionRecord
from waypointctl.training.recipe_file import load_recipe
from waypointctl.training.recipe_references import load_recipe_to_train

LAST = RECIPE.count("\n")


def refused(folder: Path, text: str) -> list[str]:
    """Return the lines of the refusal of a recipe, without the folder's name."""
    path = folder / "recipe.yaml"
    path.write_text(text)
    with pytest.raises(RecipeError) as caught:
        load_recipe_to_train(path)
    return str(caught.value).replace(f"{folder}/", "").splitlines()


def test_what_is_not_there_is_told_with_everything_else_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = f"warm_start: nowhere\nselection: {{suite: regoin}}\n{RECIPE.replace('robots: 16', 'robots: 0')}"
    head, first, *others = refused(tmp_path, text)
    assert first.startswith(
        "recipe.yaml:1:13: warm_start: nowhere: folder not found; a path is relative to this file; a policy is a "
        "folder with manifest.json, or a name. There is "
    )
    assert [head, *others] == [
        "recipe.yaml: 3 problems",
        "recipe.yaml:2:20: selection.suite: unknown suite 'regoin'; did you mean 'region'?",
        "recipe.yaml:9:32: algorithm.robots: expected a whole number from 1 to 65536; got 0",
    ]


def test_two_uses_of_one_seed_are_told_with_everything_else(tmp_path: Path) -> None:
    text = RECIPE.replace("robots: 16", "robots: 0").replace("{trials: 1}", "{trials: 1, seed: 5}")
    assert refused(tmp_path, f"{text}selection: {{seed: 5, suite: regoin}}\n") == [
        "recipe.yaml: 3 problems",
        "recipe.yaml:7:32: algorithm.robots: expected a whole number from 1 to 65536; got 0",
        f"recipe.yaml:{LAST + 1}:19: selection.seed: the seed 5 is also evaluation.seed: a policy must not be "
        "reported on the trials that selected it; use another seed for selection",
        f"recipe.yaml:{LAST + 1}:29: selection.suite: unknown suite 'regoin'; did you mean 'region'?",
    ]


@pytest.mark.parametrize(
    ("suite", "problem"),
    [
        (
            "mine",
            "unknown suite 'mine'; use paper, region, anywhere, station or a YAML file, relative to this one",
        ),
        ("mine.yaml", "mine.yaml: there is no such file; a suite's path is relative to the recipe"),
        ("sub/mine", "sub/mine: there is no such file; a suite's path is relative to the recipe"),
        ("'.'", "unknown suite '.'; use paper, region, anywhere, station or a YAML file, relative to this one"),
        ("'a.yaml\\0'", r"there is no such file; a suite's path is relative to the recipe"),
    ],
)
def test_a_suite_that_is_not_there(tmp_path: Path, suite: str, problem: str) -> None:
    (line,) = refused(tmp_path, f"{RECIPE}selection: {{suite: {suite}}}\n")
    assert line.startswith(f"recipe.yaml:{LAST + 1}:20: selection.suite: ")
    assert line.endswith(problem)


def test_what_is_wrong_with_a_suite_of_ones_own_has_its_place_there_and_comes_last(tmp_path: Path) -> None:
    (tmp_path / "near.yaml").write_text(NEAR.replace("[[3, 0]]", "[[3]]").replace("name: near", "nam: near"))
    assert [
        line.split(" ")[0] for line in refused(tmp_path, f"{RECIPE}selection: {{suite: near.yaml, seed: 0}}\n")
    ] == [
        "recipe.yaml:",
        f"recipe.yaml:{LAST + 1}:37:",
        "near.yaml:1:1:",
        "near.yaml:1:1:",
        "near.yaml:3:35:",
    ]
    (tmp_path / "near.yaml").write_text(NEAR)
    text = f"{RECIPE}selection: {{suite: near.yaml}}\n"
    (tmp_path / "recipe.yaml").write_text(text)
    assert load_recipe_to_train(tmp_path / "recipe.yaml") == load_recipe(tmp_path / "recipe.yaml")


def test_a_policy_to_start_from_that_does_not_fit(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    text = f"{RECIPE.replace('{trials: 1}', '{trials: 1, seed: 5}')}warm_start: other\n"
    record = SelectionRecord(suite="region", seed=5, trials=2, successes=1, candidates=1, last_step=1, stop_at=None)
    policy = make_policy(tmp_path / "other")
    training = policy.manifest.training.model_copy(update={"selection": record})
    make_policy(tmp_path / "other", training=training)
    seed, sizes = (line.split(": ", 3)[-1] for line in refused(tmp_path, text)[:0:-1])
    assert sizes == (
        "its hidden layers are [8, 8], the recipe's [16, 16]; give the recipe the network and an observation of that "
        "policy's sizes, or another policy in warm_start"
    )
    assert seed.startswith(
        "it was selected in 'region' with seed 5, which is also this recipe's evaluation.seed; give eval"
    )
    (tmp_path / "other" / "manifest.json").unlink()
    (line,) = refused(tmp_path, text)
    assert line.startswith(f"recipe.yaml:{LAST + 1}:13: warm_start: other: no manifest.json; a policy has")


def test_a_recipe_that_is_merely_read_needs_nothing_beside_it(tmp_path: Path) -> None:
    recipe = tiny_recipe(tmp_path, f"{RECIPE}warm_start: gone\nselection: {{suite: gone.yaml}}\n").recipe
    assert (recipe.warm_start, recipe.selection and recipe.selection.suite) == ("gone", "gone.yaml")


@pytest.mark.parametrize("wrong", ["a: [", "- 1", "selection: 3\nwarm_start: [4]", "selection: {suite: 5}"])
def test_what_is_no_name_at_all_is_told_once(tmp_path: Path, wrong: str) -> None:
    lines = refused(tmp_path, wrong)
    assert len(lines) == len(set(lines))
    assert not any("no suite" in line or "folder not found" in line for line in lines)
