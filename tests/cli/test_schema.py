from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from waypointctl.cli.app import app
from waypointctl.errors import InputError
from waypointctl.evaluation.suite import suite_schema
from waypointctl.mission.files import mission_schema
from waypointctl.training.recipe_file import recipe_schema


def test_prints_the_schema_of_a_mission() -> None:
    result = CliRunner().invoke(app, ["schema", "mission"])
    assert result.exit_code == 0
    assert json.loads(result.stdout) == mission_schema()


def test_prints_the_schema_of_a_recipe() -> None:
    result = CliRunner().invoke(app, ["schema", "recipe"])
    assert result.exit_code == 0
    assert json.loads(result.stdout) == recipe_schema()


def test_prints_the_schema_of_a_suite() -> None:
    result = CliRunner().invoke(app, ["schema", "suite"])
    assert result.exit_code == 0
    assert json.loads(result.stdout) == suite_schema()


def test_an_unknown_schema_names_those_there_are() -> None:
    result = CliRunner().invoke(app, ["schema", "rover"])
    assert isinstance(result.exception, InputError)
    with pytest.raises(InputError, match=r"unknown schema 'rover'\n  Choose one of: mission, recipe, suite"):
        raise result.exception
