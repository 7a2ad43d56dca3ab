"""Learning rate, entropy weight and phases by the step, in the recipe and in what the learner does."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from stable_baselines3 import PPO

from tests.training.tiny import RECIPE, tiny_recipe, trained
from waypointctl.errors import RecipeError
from waypointctl.mission.yaml_source import read_model
from waypointctl.training.events import CheckpointSaved, TrainingEvent, TrainingStatus
from waypointctl.training.progress import read_progress
from waypointctl.training.recipe import Recipe
from waypointctl.training.train import train

ANNEALED = RECIPE.replace("epochs: 2}", "epochs: 2, entropy: 0.04}").replace(
    "[5.0e-4, 1.0e-4],", "[5.0e-4, 1.0e-4], entropy: [0.04, 0.0],"
)


def recipe(text: str) -> Recipe:
    return read_model(text.encode(), "tiny", Recipe, RecipeError)


TINY = recipe(RECIPE)


@pytest.mark.parametrize(
    ("step", "phase", "rate", "entropy"),
    [
        (0, 0, 1e-3, 0.04),
        (320, 0, 7.5e-4, 0.04),
        (639, 0, 1e-3 - 5e-4 * 639 / 640, 0.04),
        (640, 1, 5e-4, 0.04),
        (832, 1, 3e-4, 0.02),
        (1024, 1, 1e-4, 0.0),
        (5000, 1, 1e-4, 0.0),
    ],
)
def test_a_schedule_is_a_straight_line_through_each_phase(step: int, phase: int, rate: float, entropy: float) -> None:
    annealed = recipe(ANNEALED)
    assert annealed.phase_at(step)[0] == phase
    assert annealed.schedules_at(step) == pytest.approx({"learning_rate": rate, "entropy": entropy}, abs=1e-15)


def test_a_phase_without_a_schedule_has_the_algorithms_and_a_number_is_constant() -> None:
    text = RECIPE.replace("epochs: 2}", "epochs: 2, learning_rate: 2.0e-4, entropy: [0.1, 0.3]}")
    found = recipe(text.replace("{steps: 640, learning_rate: [1.0e-3, 5.0e-4]}", "{steps: 640}"))
    assert found.schedules_at(320) == pytest.approx({"learning_rate": 2e-4, "entropy": 0.2})
    assert found.schedules_at(640)["learning_rate"] == 5e-4


@pytest.mark.parametrize("value", ["[0.01]", "[0.01, -1]", "[0.01, 2]", "2", "true", "high"])
def test_what_is_no_schedule_is_refused_with_its_place(tmp_path: Path, value: str) -> None:
    with pytest.raises(RecipeError, match=r"recipe\.yaml:10:\d+: phases\[1\]\.entropy"):
        tiny_recipe(tmp_path, ANNEALED.replace("[0.04, 0.0]", value))


@given(st.integers(min_value=2, max_value=10**12))
def test_scaling_keeps_the_sum_exactly_and_the_shares_to_a_step(steps: int) -> None:
    scaled = TINY.scaled_to(steps)
    assert scaled.total_steps == steps
    assert 0 <= scaled.last_step - steps < TINY.algorithm.iteration_steps
    for phase, original in zip(scaled.phases, TINY.phases, strict=True):
        assert phase.steps >= 1
        assert abs(phase.steps * 1024 - original.steps * steps) <= 1024
        assert (phase.reward, phase.learning_rate) == (original.reward, original.learning_rate)


def test_no_phase_vanishes() -> None:
    assert [phase.steps for phase in TINY.scaled_to(1).phases] == [1, 1]


def test_a_phase_has_its_own_reward_weights() -> None:
    first, second = TINY.task(0).reward, TINY.task(1).reward
    assert (first.alive, first.fall) == (1.0, 0.0)
    assert (second.alive, second.fall) == (0.0, 50.0)


def test_each_update_and_event_follows_the_recipe_also_after_a_resumption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    used: list[tuple[int, float, float]] = []
    update = PPO.train

    def noted(ppo: PPO) -> None:
        update(ppo)
        used.append((ppo.num_timesteps, ppo.policy.optimizer.param_groups[0]["lr"], ppo.ent_coef))

    monkeypatch.setattr(PPO, "train", noted)
    recipe_file, run = tiny_recipe(tmp_path, ANNEALED), tmp_path / "run"
    events: list[TrainingEvent] = []
    trained(recipe_file, run, rollouts=6)
    train(recipe_file, run, threads=1, resume=True, on_event=events.append)
    wanted = [(step, *recipe_file.recipe.schedules_at(step).values()) for step in range(128, 1025, 128)]
    assert used == wanted
    assert [(row.steps, *row.schedules.values()) for row in read_progress(run)] == wanted
    statuses = [event for event in events if isinstance(event, TrainingStatus)]
    assert [(status.steps, status.total_steps, status.phase) for status in statuses] == [
        (896, 1024, 1),
        (1024, 1024, 1),
    ]
    assert [tuple(status.schedules.values()) for status in statuses] == [step[1:] for step in wanted[6:]]
    saved = [event for event in events if isinstance(event, CheckpointSaved)]
    assert [(event.steps, event.folder.name) for event in saved] == [(1024, "step-0000001024")]
