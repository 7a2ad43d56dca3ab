"""What docs/training.md and docs/evaluation.md say is so."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer.main

from waypointctl.cli.app import app
from waypointctl.errors import RecipeError, SuiteError
from waypointctl.evaluation.rollout import NEAR_M, STILL_M, WINDOW_S
from waypointctl.evaluation.suite import Suite
from waypointctl.mission.yaml_source import read_model
from waypointctl.training.events import ENOUGH, WINDOW
from waypointctl.training.recipe import Recipe

DOCS = Path(__file__).resolve().parent.parent / "docs"
TRAINING, EVALUATION = ((DOCS / f"{name}.md").read_text(encoding="utf-8") for name in ("training", "evaluation"))


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


COMMANDS = [
    line.removeprefix("$ ")
    for text in (TRAINING, EVALUATION)
    for block in blocks(text, "console")
    for line in block.splitlines()
]


@pytest.mark.parametrize("block", blocks(TRAINING, "yaml"), ids=lambda block: block.split()[1])
def test_every_recipe_is_one(block: str) -> None:
    recipe = read_model(block.encode(), "training.md", Recipe, RecipeError)
    for phase in range(len(recipe.phases)):
        recipe.task(phase)


@pytest.mark.parametrize("block", blocks(EVALUATION, "yaml"), ids=lambda block: block.split()[1])
def test_every_suite_is_one_and_its_paths_can_be_drawn(block: str) -> None:
    suite = read_model(block.encode(), "evaluation.md", Suite, SuiteError)
    for path in suite.all_cases:
        assert path.trial_path(0, "test", 0, (0.0, 0.0)).shape == (path.longest, 2)


def test_there_are_as_many_as_somebody_wrote() -> None:
    assert len(blocks(TRAINING, "yaml")) >= 5
    assert len(blocks(EVALUATION, "yaml")) >= 2
    assert len(COMMANDS) >= 4


@pytest.mark.parametrize("line", COMMANDS, ids=range(len(COMMANDS)))
def test_every_command_and_option_there_is(line: str) -> None:
    program, *words = shlex.split(line)
    assert program == "waypointctl"
    command: Any = typer.main.get_command(app)
    while hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    known = {option for parameter in command.params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known


def test_the_figures_are_those_of_the_program() -> None:
    assert f"in the last {WINDOW} rollouts" in " ".join(TRAINING.split())
    assert f"fewer than {ENOUGH} have ended" in " ".join(TRAINING.split())
    assert WINDOW_S == 5
    assert "its last five seconds" in EVALUATION
    assert f"within {NEAR_M:g} m of the waypoint" in EVALUATION
    assert f"never more than {STILL_M:g} m from the middle" in EVALUATION


@pytest.mark.parametrize("text", [TRAINING, EVALUATION], ids=["training", "evaluation"])
def test_the_page_is_short_and_its_links_lead_somewhere(text: str) -> None:
    lines = text.splitlines()
    assert len(lines) < 125
    assert max(map(len, lines)) <= 120
    for link in re.findall(r"\]\(([^)]+)\)", text):
        assert link.startswith("https://") or (DOCS / link).exists(), link
