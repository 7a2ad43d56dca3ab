"""What an installed waypointctl has with it, besides its modules."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def test_the_wheel_holds_the_files_that_are_read_at_run_time(tmp_path: Path) -> None:
    wheel = pytest.importorskip("hatchling.builders.wheel", reason="needs hatchling, which builds the wheel")
    (built,) = wheel.WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with zipfile.ZipFile(built) as archive:
        held = set(archive.namelist())
    package = ROOT / "waypointctl"
    kept = {path for path in package.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    assert {path.relative_to(ROOT).as_posix() for path in kept} <= held
    names = {Path(name).name for name in held}
    assert {"ant.xml", "paper.yaml", "messages.proto", "messages_pb2.py", "py.typed", "LICENSE"} <= names
    assert {name.partition("/")[0] for name in held if ".dist-info" not in name} == {"waypointctl"}
