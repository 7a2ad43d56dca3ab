from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from waypointctl.cli.app import app

GOOD = "name: n\npolicy: p\nwaypoints: [[1, 2]] # here\n"
LOOSE = "policy: p\nname: n\nwaypoints: [[1, 2]] # here\n"
WRONG = "name: n\npolicy: p\nwaypoint: [[1, 2]]\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in (("good", GOOD), ("loose", LOOSE), ("wrong", WRONG)):
        (tmp_path / f"{name}.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def fmt(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["fmt", *arguments])
    return result.exit_code, result.stdout, result.stderr


def test_a_file_is_laid_out_in_its_place_and_then_stays(folder: Path) -> None:
    code, told, summed = fmt("loose.yaml", "good.yaml")
    assert (code, told) == (0, "loose.yaml: reformatted\n")
    assert summed == "2 missions: 1 changed, 1 already formatted\n"
    assert (folder / "loose.yaml").read_text() == GOOD
    assert (folder / "good.yaml").read_text() == GOOD
    assert fmt("loose.yaml")[:2] == (0, "")


def test_check_changes_nothing_and_exits_with_1(folder: Path) -> None:
    assert fmt("--check", "good.yaml")[0] == 0
    code, told, _ = fmt("--check", "good.yaml", "loose.yaml")
    assert (code, told) == (1, "loose.yaml: would be reformatted\n")
    assert (folder / "loose.yaml").read_text() == LOOSE


def test_diff_prints_what_would_change(folder: Path) -> None:
    code, told, _ = fmt("--diff", "loose.yaml", "good.yaml")
    assert code == 0
    assert told.startswith("--- loose.yaml\n+++ loose.yaml (formatted)\n@@")
    assert "\n-name: n\n" in told
    assert "\n+name: n\n" in told
    assert (folder / "loose.yaml").read_text() == LOOSE
    assert fmt("--diff", "--check", "loose.yaml")[0] == 1


def test_a_file_with_mistakes_is_left_alone_and_the_others_are_not(folder: Path) -> None:
    code, told, said = fmt("wrong.yaml", "missing.yaml", "loose.yaml")
    assert (code, told) == (2, "loose.yaml: reformatted\n")
    assert (
        said.startswith("2 problems\nwrong.yaml:1:1: waypoints: missing") or "wrong.yaml:3:1: waypoint: unknown" in said
    )
    assert "missing.yaml: there is no such file\n" in said
    assert said.endswith("3 missions: 1 changed, 0 already formatted, 2 not changed, with errors\n")
    assert (folder / "wrong.yaml").read_text() == WRONG


def test_a_link_to_a_mission_stays_a_link(folder: Path) -> None:
    (folder / "link.yaml").symlink_to("loose.yaml")
    assert fmt("link.yaml")[0] == 0
    assert (folder / "link.yaml").is_symlink()
    assert (folder / "loose.yaml").read_text() != LOOSE
    assert sorted(path.name for path in folder.iterdir()) == ["good.yaml", "link.yaml", "loose.yaml", "wrong.yaml"]
