"""The weight of the entropy bonus by the step, in the recipe and in the loss."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.training.tiny import RECIPE, ROLLOUT, tiny_recipe, trained, weights_of
from waypointctl.errors import RecipeError
from waypointctl.training.learner import Learner
from waypointctl.training.progress_file import read_progress

ANNEALED = RECIPE.replace("epochs: 2}", "epochs: 2, entropy: 0.04}").replace(
    "[5.0e-4, 1.0e-4],", "[5.0e-4, 1.0e-4], entropy: [0.04, 0.0],"
)


@pytest.mark.parametrize(
    ("step", "weight"), [(0, 0.04), (639, 0.04), (640, 0.04), (736, 0.03), (832, 0.02), (1024, 0.0), (5000, 0.0)]
)
def test_it_falls_in_a_straight_line_to_the_end(tmp_path: Path, step: int, weight: float) -> None:
    assert tiny_recipe(tmp_path, ANNEALED).recipe.entropy_at(step) == pytest.approx(weight, abs=1e-15)


@pytest.mark.parametrize("weight", [0.0, 0.1, 0.3])
def test_a_phase_without_one_has_ppos_exactly(tmp_path: Path, weight: float) -> None:
    recipe = tiny_recipe(tmp_path, RECIPE.replace("epochs: 2}", f"epochs: 2, entropy: {weight}}}")).recipe
    assert {recipe.entropy_at(step) for step in range(0, 1100, 7)} == {weight}


def test_each_update_has_the_weight_of_its_step_also_after_a_resumption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    used: list[tuple[int, float]] = []
    learn = Learner.learn

    def learn_and_note(learner: Learner, callback: object) -> None:
        update = learner.ppo.train

        def noted() -> None:
            used.append((learner.steps, learner.ppo.ent_coef))
            update()

        learner.ppo.train = noted  # type: ignore[method-assign]
        learn(learner, callback)  # type: ignore[arg-type]

    monkeypatch.setattr(Learner, "learn", learn_and_note)
    recipe_file, run = tiny_recipe(tmp_path, ANNEALED), tmp_path / "run"
    trained(recipe_file, run, rollouts=6)
    trained(recipe_file, run, resume=True)
    wanted = [0.04, 0.04, 0.04, 0.04, 0.04, 0.04 * 2 / 3, 0.04 / 3, 0.0]
    assert [steps for steps, _ in used] == [ROLLOUT * rollout for rollout in range(1, 9)]
    assert [weight for _, weight in used] == pytest.approx(wanted, abs=1e-15)
    assert [row.entropy for row in read_progress(run)] == pytest.approx(wanted, abs=1e-15)


def test_it_changes_what_is_learnt(tmp_path: Path) -> None:
    found = []
    for name, text in (("none", RECIPE), ("annealed", ANNEALED)):
        (tmp_path / name).mkdir()
        recipe_file = tiny_recipe(tmp_path / name, text)
        trained(recipe_file, tmp_path / name / "run", rollouts=1)
        found.append(weights_of(next((tmp_path / name / "run" / "checkpoints").iterdir())))
    assert found[0] != found[1]


@pytest.mark.parametrize("value", ["[0.01]", "[0.01, -1]", "0.01", "[0.01, 2]"])
def test_what_is_no_pair_of_weights_is_refused(tmp_path: Path, value: str) -> None:
    with pytest.raises(RecipeError, match=r"recipe\.yaml:10:\d+: phases\[1\]\.entropy"):
        tiny_recipe(tmp_path, ANNEALED.replace("[0.04, 0.0]", value))
