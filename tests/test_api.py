"""The library: every name of `__all__` is there, typed and documented, and loaded no sooner than it is used."""

from __future__ import annotations

import ast
import inspect
import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import waypointctl
from waypointctl import messages

SOURCE = Path(waypointctl.__file__).read_text()
HEAVY = ("numpy", "pydantic", "mujoco", "torch", "onnxruntime", "matplotlib", "gymnasium", "mcap", "rich", "typer")
PLUGIN = """
import waypointctl

@waypointctl.observation_group(name="half_height", unit="m", components=["half_height"])
def half_height(view):
    return view.height / 2

@waypointctl.reward_term(name="uprightness", unit="1")
def uprightness(view):
    return view.up
"""
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


ALIASES = {"Plugins", "Sink"}  # they have no docstring; docs/api.py has a line for each


@pytest.mark.parametrize("name", sorted({*waypointctl.__all__} - {"__version__"} - ALIASES))
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
    assert not waypointctl.open_log(tmp_path / "cut.mcap", allow_truncated=True).is_complete
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(waypointctl.OutputError, match="not a log"):
        waypointctl.fly(mission, log=tmp_path / "notes.txt")


class Still(waypointctl.Policy):
    """Observes a group, and is rewarded by a term, that are not built in."""

    robot = "ant"
    observation_layout = ("height", "half_height")
    reward_weights = {"uprightness": 0.5}  # noqa: RUF012

    def act(self, observation: np.ndarray) -> np.ndarray:
        return np.zeros((len(observation), 8))


def test_own_groups_and_terms_are_in_the_log_and_are_given_to_verify(tmp_path: Path) -> None:
    (tmp_path / "terms.py").write_text(PLUGIN)
    path = str(tmp_path / "terms.py")
    plugins = waypointctl.load_plugins(path)
    assert [plugin.name for plugin in plugins] == ["half_height", "uprightness"]
    for paths in ([path], Path(path), [Path(path)]):
        assert len(waypointctl.load_plugins(paths)) == 2
    mission = waypointctl.Mission.model_validate(
        {"name": "still", "policy": "none", "waypoints": [{"position_m": [9.0, 0.0], "timeout_s": 0.3}]}
    )
    for refused in (lambda: waypointctl.fly(mission, Still()), lambda: waypointctl.evaluate(Still(), trials=1)):
        with pytest.raises(waypointctl.PolicyError, match="half_height"):
            refused()
    waypointctl.fly(mission, Still(), log=tmp_path / "still.mcap", plugins=plugins)
    log = waypointctl.open_log(tmp_path / "still.mcap")
    names = [name for name in log.arrays("/reward") if name not in ("time_ns", "step", "total")]
    assert log.metadata["reward_terms"].split() == names
    assert "uprightness" in names
    assert waypointctl.verify(log.path, plugins).verdict is waypointctl.Verdict.EQUIVALENT
    without = waypointctl.verify(log.path)
    assert without.verdict is waypointctl.Verdict.UNVERIFIABLE
    assert "terms.py (SHA-256 " in without.reason
    assert "\n" not in without.reason


def test_a_robot_and_a_recipe_are_taken_by_name_or_path(tmp_path: Path) -> None:
    (tmp_path / "short.yaml").write_text(MISSION)
    with pytest.raises(waypointctl.RobotError, match="no robot 'mule'"):
        waypointctl.fly(tmp_path / "short.yaml", robot="mule")
    (tmp_path / "own.yaml").write_text("name: own\nphases: [{steps: 64}]\n")
    assert waypointctl.load_recipe(str(tmp_path / "own.yaml")).path == tmp_path / "own.yaml"


ANY: Any = waypointctl
SHORT = waypointctl.Mission.model_validate(
    {"name": "short", "policy": "ant-waypoint", "waypoints": [{"position_m": [1.0, 0.0]}]}
)


@pytest.mark.parametrize(
    "call",
    [
        lambda: ANY.fly({"name": "short"}),
        lambda: ANY.fly(SHORT, sink=3),
        lambda: ANY.fly(SHORT, log=3),
        lambda: ANY.fly(SHORT, navigator=3),
        lambda: ANY.fly(SHORT, plugins=3),
        lambda: ANY.load_mission(3),
        lambda: ANY.load_policy(3),
        lambda: ANY.load_robot(3),
        lambda: ANY.load_suite(3),
        lambda: ANY.open_log(3),
        lambda: ANY.verify(3),
        lambda: ANY.train(3, "out"),
        lambda: ANY.evaluate("ant-waypoint", robot=3),
        lambda: ANY.BatchedWaypointEnv({}, 1, 0),
        lambda: ANY.fly(SHORT, 3),
        lambda: ANY.fly(SHORT, robot=3),
        lambda: ANY.evaluate(3),
        lambda: ANY.evaluate("ant-waypoint", 3),
        lambda: ANY.load_recipe(3),
        lambda: ANY.load_plugins(3),
        lambda: ANY.load_plugins([3]),
    ],
)
def test_an_argument_of_a_wrong_type_is_refused(call: Callable[[], object]) -> None:
    with pytest.raises(waypointctl.InputError, match=r"(int|dict) is not allowed; give "):
        call()


@pytest.mark.parametrize(
    "call",
    [
        lambda: ANY.evaluate("ant-waypoint", trials=0),
        lambda: ANY.evaluate("ant-waypoint", trials=1.5),
        lambda: ANY.evaluate("ant-waypoint", trials=10**9),
        lambda: ANY.evaluate("ant-waypoint", trials=1, seed="1"),
        lambda: ANY.evaluate("ant-waypoint", trials=1, threads=-1),
        lambda: ANY.load_policy("ant-waypoint", threads="1"),
        lambda: ANY.BatchedWaypointEnv(waypointctl.TaskConfig(), 0, 0),
        lambda: ANY.BatchedWaypointEnv(waypointctl.TaskConfig(), 1, -1),
    ],
)
def test_a_number_out_of_its_bounds_is_refused(call: Callable[[], object]) -> None:
    with pytest.raises(waypointctl.InputError, match="is a whole number from "):
        call()


def test_a_policy_is_evaluated_with_a_robot_or_without(tmp_path: Path) -> None:
    policy, robot = waypointctl.load_policy("ant-waypoint"), waypointctl.load_robot("ant")
    suite = tmp_path / "near.yaml"
    suite.write_text("name: near\ncases: [{name: ahead, waypoints: [[0.1, 0]]}]\n")
    found = [
        waypointctl.evaluate(given, suite, trials=1, robot=body)
        for given, body in ((policy, None), ("ant-waypoint", robot), (policy, "ant"))
    ]
    assert len({result.model_dump_json() for result in found}) == 1
    for name, content in robot.files.items():
        (tmp_path / "ant2").mkdir(exist_ok=True)
        (tmp_path / "ant2" / name).write_bytes(content.replace(b"name: ant\n", b"name: ant2\n"))
    with pytest.raises(waypointctl.PolicyError, match="made for the robot 'ant', not 'ant2'"):
        waypointctl.evaluate(policy, suite, trials=1, robot=tmp_path / "ant2")
