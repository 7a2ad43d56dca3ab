"""What the README and the docs say is so."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest
import typer.main

from waypointctl.cli.main import app
from waypointctl.errors import MissionError, SuiteError
from waypointctl.evaluation.suite import Suite
from waypointctl.mission.files import parse_mission
from waypointctl.mission.yaml_source import read_model

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
