"""docs/robots.md: the rover goes from its folder to a log that is proven, by the commands of the page."""

from __future__ import annotations

import re
import shlex
import textwrap
from pathlib import Path

import pytest
from typer.testing import CliRunner

from waypointctl.cli.app import app
from waypointctl.robots.load import load_robot

PAGE = (Path(__file__).parents[2] / "docs" / "robots.md").read_text(encoding="utf-8")
SECTION = PAGE.partition("## From a folder to a flight")[2]


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", SECTION, re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory with the page's four files, the training cut short."""
    monkeypatch.chdir(tmp_path)
    (recipe, mission), (mjcf,) = blocks("yaml"), blocks("xml")
    (description,) = re.findall(r"`robots/rover/robot.yaml`:\n\n((?:    .*\n)+)", SECTION)
    robot = tmp_path / "robots" / "rover"
    robot.mkdir(parents=True)
    (robot / "rover.xml").write_text(mjcf)
    (robot / "robot.yaml").write_text(textwrap.dedent(description))
    small = recipe.replace("trials: 20", "trials: 1").replace("robots: 64", "robots: 16")
    (tmp_path / "rover-train.yaml").write_text(small)
    (tmp_path / "rover.yaml").write_text(mission)
    return tmp_path


def test_the_rover_drives_as_the_page_has_it(folder: Path) -> None:
    robot = load_robot(folder / "robots" / "rover")
    assert (robot.joint_names, robot.num_actions) == (("left_wheel", "right_wheel"), 2)
    train, validate, run, replay = (shlex.split(line[2:])[1:] for line in blocks("console")[0].splitlines())
    for arguments, codes in (([*train, "--steps", "1"], {0}), (validate, {0}), (run, {0, 1}), (replay, {0})):
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code in codes, (arguments, result.output, result.exception)


def test_a_copy_of_a_robot_that_comes_with_waypointctl_is_one(tmp_path: Path) -> None:
    for name, content in load_robot("ant").files.items():
        (tmp_path / name).write_bytes(content.replace(b"name: ant\n", b"name: ant2\n"))
    assert load_robot(tmp_path).name == "ant2"
