"""The library: every name of `__all__` is there, typed and documented, and loaded no sooner than it is used."""

from __future__ import annotations

import ast
import inspect
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import waypointctl
from waypointctl import messages

SOURCE = Path(waypointctl.__file__).read_text()
HEAVY = ("numpy", "pydantic", "mujoco", "torch", "onnxruntime", "matplotlib", "gymnasium", "mcap", "rich", "typer")
MISSION = """
name: short
policy: ant-waypoint
seed: 3
waypoints: [{position: [1 m, 0 m]}]
"""


def imported_for_types() -> dict[str, str]:
    """Return the names that type checkers see, with their modules."""
    block = next(node for node in ast.parse(SOURCE).body if isinstance(node, ast.If))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: str(node.module) for node in imports for alias in node.names}


def test_names_for_people_types_and_loading_are_the_same() -> None:
    seen = imported_for_types()
    assert {*seen, "__version__"} == set(waypointctl.__all__) == set(dir(waypointctl))
    assert list(waypointctl.__all__) == sorted(waypointctl.__all__)
    for name, module in seen.items():
        if name != "messages":
            assert name in waypointctl._MODULES[module.removeprefix("waypointctl.")]


def test_the_page_is_what_its_command_writes() -> None:
    docs = Path(__file__).parents[1] / "docs"
    assert runpy.run_path(str(docs / "api.py"))["page"]() == (docs / "api.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted({*waypointctl.__all__} - {"__version__"}))
def test_each_name_is_there_and_documented(name: str) -> None:
    assert inspect.getdoc(getattr(waypointctl, name))


def test_importing_loads_nothing_heavy() -> None:
    code = f"import sys, waypointctl; print([name for name in {HEAVY} if name in sys.modules])"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"


@pytest.mark.parametrize(
    ("use", "unneeded"),
    [
        ("load_mission", ("mujoco", "torch", "onnxruntime", "gymnasium")),
        ("fly", ("torch", "gymnasium", "matplotlib", "rich", "typer")),
        ("verify", ("torch", "gymnasium", "matplotlib", "rich", "typer")),
        ("evaluate", ("torch", "gymnasium", "matplotlib", "rich", "typer")),
    ],
)
def test_a_name_loads_no_more_than_it_needs(use: str, unneeded: tuple[str, ...]) -> None:
    code = f"import sys, waypointctl; waypointctl.{use}; print([name for name in {unneeded} if name in sys.modules])"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"


def test_what_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'warp'"):
        getattr(waypointctl, "warp")  # noqa: B009 type checkers know that it is not there


def test_a_flight_from_file_to_arrays(tmp_path: Path) -> None:
    mission, path = tmp_path / "short.yaml", tmp_path / "short.mcap"
    mission.write_text(MISSION)
    seen: list[messages.Message] = []
    result = waypointctl.fly(str(mission), sink=seen.append, log=path, seed=5)
    assert (result.outcome, result.seed, result.log) == ("success", 5, path)
    assert waypointctl.verify(path).verdict is waypointctl.Verdict.EXACT
    with waypointctl.open_log(path) as log:
        assert [type(message) for message in log] == [type(message) for message in seen]
        assert (log.mission_name, log.metadata["seed"], len(log.waypoints)) == ("short", "5", 1)
        assert log.summary.outcome == "success"
        states = [message for message in seen if isinstance(message, messages.State)]
        columns = log.arrays("/state")
        assert columns["time_ns"].tolist() == [state.time_ns for state in states]
        np.testing.assert_array_equal(columns["qpos"], [state.qpos for state in states])
        rewards = log.arrays("/reward")
        assert rewards["progress"].shape == rewards["total"].shape == (log.count("/reward"),)
        assert set(log.arrays("/action")["source"]) == {"policy"}
        assert log.arrays("/console") == {}
        with pytest.raises(waypointctl.LogError, match="/tf"):
            log.arrays("/tf")


def test_objects_are_taken_as_well_as_paths_and_names(tmp_path: Path) -> None:
    (tmp_path / "short.yaml").write_text(MISSION)
    file = waypointctl.load_mission(tmp_path / "short.yaml")
    policy, robot = waypointctl.load_policy("ant-waypoint"), waypointctl.load_robot("ant")
    from_file = waypointctl.fly(file, policy, log=tmp_path / "file.mcap", robot=robot)
    in_memory = waypointctl.fly(file.mission, policy, log=tmp_path / "memory.mcap")
    assert from_file.sim_time_ns == in_memory.sim_time_ns
    assert waypointctl.verify(tmp_path / "memory.mcap").verdict is waypointctl.Verdict.EXACT


def test_a_part_is_read_up_to_where_it_is_whole(tmp_path: Path) -> None:
    mission = waypointctl.Mission.model_validate(
        {"name": "part", "policy": "ant-waypoint", "waypoints": [{"position_m": [1.0, 0.0]}]}
    )
    waypointctl.fly(mission, log=tmp_path / "part.mcap")
    cut = (tmp_path / "part.mcap").read_bytes()[:-3000]
    (tmp_path / "part.mcap.part").write_bytes(cut)
    (tmp_path / "cut.mcap").write_bytes(cut)
    log = waypointctl.open_log(tmp_path / "part.mcap.part")
    assert not log.is_complete
    assert log.arrays("/state")["step"][0] == 0
    with pytest.raises(waypointctl.LogError):
        waypointctl.open_log(tmp_path / "cut.mcap")
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(waypointctl.OutputError, match="not a log"):
        waypointctl.fly(mission, log=tmp_path / "notes.txt")
