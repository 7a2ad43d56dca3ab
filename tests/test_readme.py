"""What the README and the docs say is so."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import pytest
import typer.main
from mujoco import MjModel

from waypointctl.cli.app import app
from waypointctl.errors import MissionError, SuiteError
from waypointctl.evaluation.suite import Suite
from waypointctl.mission.files import parse_mission
from waypointctl.mission.yaml_source import read_model
from waypointctl.robots.load import load_robot

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMANDS = sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]


def yaml_blocks() -> list[str]:
    return re.findall(r"```yaml\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_in_the_readme(command: str) -> None:
    assert f"waypointctl {command}" in README


def test_the_readme_names_no_command_that_is_not() -> None:
    named = set(re.findall(r"\$ waypointctl (\w+)", README))
    assert named
    assert named <= set(COMMANDS)


def test_the_readmes_missions_and_suite_are_read() -> None:
    mission, far, suite = yaml_blocks()
    assert parse_mission(mission.encode(), "README.md").legs()[1].hold_s == 4.0
    operated = parse_mission(far.encode(), "README.md")
    assert operated.link.up.windows is not None
    assert [command.do for command in operated.schedule] == ["hold", "resume"]
    assert read_model(suite.encode(), "README.md", Suite, SuiteError).cases[0].name == "there-and-back"
    with pytest.raises(MissionError):
        parse_mission(suite.encode(), "README.md")


@pytest.mark.parametrize("script", ["docs/readme_suites.py", "docs/paper_tables.py"])
def test_the_readmes_tables_are_the_policies_evaluations(script: str) -> None:
    (table,) = re.findall(rf"<!-- python {re.escape(script)} -->\n(.*?)\n<!-- end -->", README, re.DOTALL)
    assert table == runpy.run_path(str(ROOT / script))["block"]()


def test_the_readmes_flights_take_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    (table,) = re.findall(r"<!-- python docs/readme_delay\.py -->\n(.*?)\n<!-- end -->", README, re.DOTALL)
    runpy.run_path(str(ROOT / "docs" / "readme_delay.py"))["main"]()
    assert capsys.readouterr().out.strip() == table


def test_the_first_screen_names_the_gravity_and_the_ground_that_missions_are_flown_on() -> None:
    first_screen = " ".join(README.split("```console")[0].split())
    robot = load_robot("ant").model
    grounds = [geom for geom in range(robot.ngeom) if robot.geom_bodyid[geom] == 0]
    assert [int(robot.geom_type[geom]) for geom in grounds] == [0]  # a plane, and nothing else
    assert tuple(robot.geom_quat[grounds[0]]) == (1, 0, 0, 0)
    assert tuple(robot.opt.gravity[:2]) == (0, 0)
    assert f"Earth's gravity, {-robot.opt.gravity[2]:g} m/s²" in first_screen
    assert f"on level, flat ground without end or obstacles** (sliding friction {_sliding(robot):g})" in first_screen


def _sliding(robot: MjModel) -> float:
    """Return the friction between robot and ground: MuJoCo takes the larger one of two that touch."""
    return float(np.max(robot.geom_friction[:, 0]))


@pytest.mark.parametrize(
    "document",
    [
        "README.md",
        "ARCHITECTURE.md",
        "DECISIONS.md",
        "CHANGELOG.md",
        "docs/paper.md",
        "docs/delay.md",
        "docs/commands.md",
        "docs/console.md",
        "docs/resume.md",
    ],
)
def test_links_lead_somewhere(document: str) -> None:
    text = (ROOT / document).read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)]+)\)", text):
        assert link.startswith("https://") or ((ROOT / document).parent / link).exists(), link


def test_the_architecture_fits_a_page() -> None:
    assert len((ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").splitlines()) <= 60


@pytest.mark.parametrize(
    "part", sorted(p.name for p in (ROOT / "waypointctl").iterdir() if (p / "__init__.py").exists())
)
def test_every_part_is_in_the_architecture(part: str) -> None:
    assert f"`{part}/`" in (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")


def test_nothing_is_left_to_be_filled_in() -> None:
    assert "@@" not in README
