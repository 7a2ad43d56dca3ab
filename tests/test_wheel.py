"""What an installed waypointctl has with it, besides its modules."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NAME = "ant-waypoint"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel's content, as pip unpacks it into site-packages."""
    wheel = pytest.importorskip("hatchling.builders.wheel", reason="needs hatchling, which builds the wheel")
    folder = tmp_path_factory.mktemp("built")
    (built,) = wheel.WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    with zipfile.ZipFile(built) as archive:
        archive.extractall(folder / "site-packages")
    return folder / "site-packages"


def test_the_wheel_holds_the_files_that_are_read_at_run_time(installed: Path) -> None:
    held = {path.relative_to(installed).as_posix() for path in installed.rglob("*") if path.is_file()}
    package = ROOT / "waypointctl"
    kept = {path for path in package.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    assert {path.relative_to(ROOT).as_posix() for path in kept} <= held
    names = {Path(name).name for name in held}
    assert {"ant.xml", "robot.yaml", "paper.yaml", "messages.proto", "messages_pb2.py", "py.typed", "LICENSE"} <= names
    assert {name.partition("/")[0] for name in held if ".dist-info" not in name} == {"waypointctl"}


def test_the_wheel_holds_the_flagship_policy_and_no_other(installed: Path) -> None:
    (shipped,) = (installed / "waypointctl" / "policies").iterdir()
    held, own = ({path.name: path.read_bytes() for path in it.iterdir()} for it in (shipped, ROOT / "policies" / NAME))
    assert (shipped.name, held) == (NAME, own)


def test_an_installed_waypointctl_has_all_it_needs_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    def waypointctl(*arguments: str) -> tuple[int, str, str]:
        command = [sys.executable, "-m", "waypointctl", *arguments]
        environment = os.environ | {"PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1"}
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        return done.returncode, done.stdout, done.stderr

    (listed,) = json.loads(waypointctl("policies", "--json")[1])["policies"]
    assert listed["folder"] == str(installed / "waypointctl" / "policies" / NAME)
    assert (listed["name"], listed["shipped"], len(listed["evaluations"])) == (NAME, True, 5)
    assert waypointctl("init", ".")[0] == 0
    code, out, err = waypointctl("run", "mission.yaml", "--json")
    assert (code, json.loads(out)["outcome"]) == (0, "success"), err
    code, out, err = waypointctl("eval", NAME, "--suite", "suite.yaml", "--trials", "2", "--json")
    assert (code, json.loads(out)["policy_sha256"]) == (0, listed["policy_sha256"]), err
    code, _, err = waypointctl("eval", NAME, "--trials", "1", "--save")
    assert code == 2
    assert "part of the installed waypointctl" in err
