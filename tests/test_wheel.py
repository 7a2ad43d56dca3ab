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

# Runs commands one after the other in one process and prints what each came to.
PROGRAM = """
import io, json, sys
from waypointctl.cli.main import main
own, found = sys.stdout, []
for arguments in json.loads(sys.argv[1]):
    sys.argv = ["waypointctl", *arguments]
    sys.stdout, sys.stderr = io.StringIO(), io.StringIO()
    out, err = sys.stdout, sys.stderr
    try:
        main()
    except SystemExit as end:
        found.append({"code": end.code or 0, "out": out.getvalue(), "err": err.getvalue()})
print(json.dumps(found), file=own)
"""


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
    commands = (
        ("policies", "--json"),
        ("init", "."),
        ("run", "mission.yaml", "--json"),
        ("eval", NAME, "--suite", "suite.yaml", "--trials", "2", "--json"),
        ("eval", NAME, "--trials", "1", "--save"),
    )
    environment = os.environ | {"PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1"}
    command = [sys.executable, "-c", PROGRAM, json.dumps(commands)]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    listing, init, flight, evaluation, saving = json.loads(done.stdout)
    (listed,) = json.loads(listing["out"])["policies"]
    assert listed["folder"] == str(installed / "waypointctl" / "policies" / NAME)
    assert (listed["name"], listed["shipped"], len(listed["evaluations"])) == (NAME, True, 5)
    assert init["code"] == 0
    assert (flight["code"], json.loads(flight["out"])["outcome"]) == (0, "success"), flight["err"]
    assert evaluation["code"] == 0, evaluation["err"]
    assert json.loads(evaluation["out"])["policy_sha256"] == listed["policy_sha256"]
    assert saving["code"] == 2
    assert "part of the installed waypointctl" in saving["err"]
