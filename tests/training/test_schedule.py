"""Learning rate and phases by the step, in the recipe and in what the learner does."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.training.tiny import RECIPE, tiny_recipe
from waypointctl.errors import RecipeError
from waypointctl.mission.yaml_source import read_model
from waypointctl.training.recipe import Recipe
from waypointctl.training.status import CheckpointSaved, News, TrainingStatus
from waypointctl.training.train import train

TINY = read_model(RECIPE.encode(), "tiny", Recipe, RecipeError)


@pytest.mark.parametrize(
    ("step", "phase", "rate"),
    [
        (0, 0, 1e-3),
        (320, 0, 7.5e-4),
        (639, 0, 1e-3 - 5e-4 * 639 / 640),
        (640, 1, 5e-4),
        (832, 1, 3e-4),
        (1024, 1, 1e-4),
        (5000, 1, 1e-4),
    ],
)
def test_the_rate_falls_in_a_straight_line_through_each_phase(step: int, phase: int, rate: float) -> None:
    assert TINY.phase_at(step)[0] == phase
    assert TINY.learning_rate_at(step) == pytest.approx(rate, rel=1e-12)


@given(st.integers(min_value=2, max_value=10**12))
def test_scaling_keeps_the_sum_exactly_and_the_shares_to_a_step(steps: int) -> None:
    scaled = TINY.scaled_to(steps)
    assert scaled.total_steps == steps
    for phase, original in zip(scaled.phases, TINY.phases, strict=True):
        assert phase.steps >= 1
        assert abs(phase.steps * 1024 - original.steps * steps) <= 1024
        assert (phase.reward, phase.learning_rate) == (original.reward, original.learning_rate)


def test_no_phase_vanishes() -> None:
    assert [phase.steps for phase in TINY.scaled_to(1).phases] == [1, 1]


def test_a_phase_is_paid_by_its_own_weights() -> None:
    first, second = TINY.task(0).reward, TINY.task(1).reward
    assert (first.alive, first.fall) == (1.0, 0.0)
    assert (second.alive, second.fall) == (0.0, 50.0)


def test_what_is_told_follows_the_recipe(tmp_path: Path) -> None:
    news: list[News] = []
    recipe_file = tiny_recipe(tmp_path)
    train(recipe_file, tmp_path / "run", run=tmp_path / "run", threads=1, watch=news.append)
    statuses = [told for told in news if isinstance(told, TrainingStatus)]
    assert [status.steps for status in statuses] == [128 * rollout for rollout in range(1, 9)]
    assert [status.phase for status in statuses] == [0, 0, 0, 0, 1, 1, 1, 1]
    assert [status.learning_rate for status in statuses] == [TINY.learning_rate_at(s.steps) for s in statuses]
    saved = [told for told in news if isinstance(told, CheckpointSaved)]
    assert [told.steps for told in saved] == [256, 512, 768, 1024]
    assert [told.folder.name for told in saved] == [f"step-{told.steps:010d}" for told in saved]
    assert all((told.folder / "manifest.json").is_file() for told in saved)
