from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.mission import policy_name
from waypointctl.mission.files import load_mission
from waypointctl.mission.policy_name import (
    SHIPPED,
    is_installed,
    policies_there_are,
    policy_folder,
    policy_reference,
    shipped_folder,
)
from waypointctl.policy.bundle import load_policy

ROOT = Path(__file__).resolve().parents[2]
NAME = "ant-waypoint"


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def holding(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "manifest.json").touch()
    return folder


def test_the_first_place_that_holds_a_policy_is_taken(place: Path) -> None:
    beside = place / "missions"
    (beside / NAME).mkdir(parents=True)  # no policy: a project that is called so
    (place / "policies" / NAME).mkdir(parents=True)
    assert policy_folder(NAME, beside) == shipped_folder(NAME)
    holding(place / "policies" / NAME)
    assert policy_folder(NAME, beside) == Path("policies") / NAME
    holding(beside / NAME)
    assert policy_folder(NAME, beside) == beside / NAME


@pytest.mark.parametrize(
    "named", ["./ant-waypoint", "ant-waypoint/", "policies/ant-waypoint", "../ant-waypoint", "/ant-waypoint", ".", ".."]
)
def test_a_path_is_taken_as_it_is(place: Path, named: str) -> None:
    assert policy_folder(named) == Path(named)
    assert policy_folder(named, place) == place / named


@pytest.mark.parametrize("named", ["nowhere", "a\0b", "x" * 5000, "", "\x1b[31m", "*"])
def test_what_is_nowhere_is_refused_with_what_there_is(place: Path, named: str) -> None:
    holding(place / "policies" / "mine")
    with pytest.raises(PolicyError) as caught:
        load_policy(policy_folder(named))
    if named:  # the working directory itself has policies in it, which are named another way
        assert str(caught.value.hint).startswith("A policy is a folder with manifest.json, or a name. There is")
        assert "ant-waypoint (shipped with waypointctl), policies/mine" in str(caught.value.hint)


def test_a_damaged_policy_is_not_replaced_by_one_of_another_place(place: Path) -> None:
    (place / "policies" / "mine").mkdir(parents=True)
    (place / "policies" / "mine" / "policy.onnx").touch()
    with pytest.raises(PolicyError, match=r"policies/mine: no manifest\.json"):
        load_policy(policy_folder("mine"))


def test_the_hint_names_the_nearest_and_does_not_grow_with_the_folder(place: Path) -> None:
    assert policies_there_are("ant-waypiont").endswith("Did you mean 'ant-waypoint'?")
    for number in range(100):
        holding(place / "policies" / f"p{number:03}")
    assert policies_there_are("zzz").endswith("policies/p018 and 81 more.")


def test_a_mission_and_the_command_line_find_the_same(place: Path) -> None:
    mission = place / "elsewhere" / "m.yaml"
    mission.parent.mkdir()
    mission.write_text(f"name: m\npolicy: {NAME}\nwaypoints: [[1, 1]]\n")
    assert load_mission(mission).policy_path == shipped_folder(NAME) == policy_folder(NAME)
    assert load_policy(policy_folder(NAME)).manifest.name == NAME


def test_a_file_is_given_what_finds_the_same_policy(place: Path) -> None:
    assert policy_reference(NAME, place / "missions") == NAME
    holding(place / "policies" / NAME)
    assert policy_reference(NAME, place / "missions") == f"../policies/{NAME}"
    assert policy_reference("./mine", place) == "mine"


def test_the_installed_policies_are_found_before_those_of_a_checkout(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not is_installed(shipped_folder(NAME))
    monkeypatch.setattr(policy_name, "_PACKAGE", place / "site-packages" / "waypointctl")
    installed = holding(place / "site-packages" / "waypointctl" / "policies" / NAME)
    assert shipped_folder(NAME) == installed
    assert is_installed(installed)


def test_what_is_called_shipped_is_what_the_wheel_is_given() -> None:
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["only-include"] == ["waypointctl", *(f"policies/{name}" for name in SHIPPED)]
