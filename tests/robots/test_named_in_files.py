"""A mission, a suite and a recipe name a robot by its name, or by a path that is relative to their file."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.robots.folders import write_folder
from waypointctl.errors import RobotError
from waypointctl.evaluation.suite import load_suite
from waypointctl.flight.fly import robot_of
from waypointctl.mission.files import load_mission, parse_mission

MISSION = "name: go\npolicy: ./policy\nwaypoints: [[1, 0]]\nrobot: {}\n"
SUITE = "name: go\nrobot: {}\ncases: [{{name: a, waypoints: [[1, 0]]}}]\n"


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folders robots/cart and files/, with the latter's parent as the working directory."""
    write_folder(tmp_path / "robots" / "cart")
    (tmp_path / "files").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_mission_names_a_folder_relative_to_its_file(work: Path) -> None:
    path = Path("files", "go.yaml")
    path.write_text(MISSION.format("../robots/cart"))
    assert robot_of(load_mission(path)).name == "cart"
    path.write_text(MISSION.format(work / "robots" / "cart"))
    assert robot_of(load_mission(path)).name == "cart"


def test_a_mission_in_the_working_directory_names_a_folder_beside_it(work: Path) -> None:
    Path("go.yaml").write_text(MISSION.format("./robots/cart"))
    assert robot_of(load_mission(Path("go.yaml"))).name == "cart"


def test_a_name_stays_a_name_wherever_the_mission_is(work: Path) -> None:
    write_folder(work / "files" / "ant")
    assert parse_mission(MISSION.format("ant").encode(), "files/go.yaml").robot == "ant"


@pytest.mark.parametrize(
    ("named", "problem"),
    [
        ("atn", "files/go.yaml:4:8: robot: there is no robot 'atn'; there are: ant; did you mean 'ant'?"),
        ("../robots/ant", "files/go.yaml:4:8: robot: files/../robots/ant: folder not found"),
    ],
)
def test_a_robot_that_is_not_there_has_its_place_in_the_mission(work: Path, named: str, problem: str) -> None:
    path = Path("files", "go.yaml")
    path.write_text(MISSION.format(named))
    with pytest.raises(RobotError) as caught:
        robot_of(load_mission(path))
    assert str(caught.value).startswith(f"{problem}\n")


def test_a_suite_names_a_folder_relative_to_its_file_or_leaves_it_to_the_policy(work: Path) -> None:
    path = Path("files", "suite.yaml")
    path.write_text(SUITE.format("../robots/cart"))
    assert load_suite(str(path)).robot == "files/../robots/cart"
    assert load_suite("region").robot is None
