from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.mission.drawn import missions
from waypointctl.errors import MissionError
from waypointctl.mission.files import dump_mission, load_mission, parse_mission
from waypointctl.mission.link import Link, LinkDirection
from waypointctl.mission.mission import Mission

MISSIONS = Path(__file__).parents[2] / "missions"
SHIPPED = sorted(MISSIONS.glob("*.yaml"))


def shipped(name: str) -> Mission:
    return load_mission(MISSIONS / f"{name}.yaml").mission


def test_there_are_missions_to_check() -> None:
    assert len(SHIPPED) >= 10


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_mission_is_named_as_its_file_and_explains_itself(path: Path) -> None:
    file = load_mission(path)
    assert file.mission.name == path.stem
    assert file.mission.description
    assert file.source == path.read_bytes()
    assert file.source.startswith(b"# ")
    assert file.policy_path.resolve() == MISSIONS.parent / "policies" / "ant-waypoint"


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_mission_is_dumped_and_read_back(path: Path) -> None:
    mission = load_mission(path).mission
    assert parse_mission(dump_mission(mission).encode(), "dump", mission.files) == mission


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_mission_can_be_walked_in_its_time(path: Path) -> None:
    mission = load_mission(path).mission
    at = mission.start.position_m
    possible = 0
    for leg in mission.legs():
        if math.dist(at, (leg.x_m, leg.y_m)) < 1.5 * leg.timeout_s:  # the ant walks 1.5 m/s and more
            at = (leg.x_m, leg.y_m)
            possible += 1
    expected = mission.num_legs if mission.expect.reached == "all" else mission.expect.reached
    assert possible == expected


@pytest.mark.parametrize("name", ["paper-two-point-moon", "paper-two-point-moon-waypoint"])
def test_the_papers_path_at_lunar_delay(name: str) -> None:
    mission = shipped(name)
    assert [(leg.x_m, leg.y_m, leg.acceptance, leg.tolerance_m) for leg in mission.legs()] == [
        (7.0, 12.0, "box", 0.5),
        (14.0, 14.0, "box", 0.5),
    ]
    assert mission.link == Link(up=LinkDirection(delay_s=1.28), down=LinkDirection(delay_s=1.28))


def test_the_two_flights_of_the_papers_path_differ_in_autonomy_alone() -> None:
    plan, step = shipped("paper-two-point-moon"), shipped("paper-two-point-moon-waypoint")
    assert (plan.autonomy, step.autonomy) == ("mission", "waypoint")
    same = {"autonomy": "mission", "name": "", "description": ""}
    assert plan.model_copy(update=same) == step.model_copy(update=same)


def test_the_yard_loop_goes_through_all_four_quadrants() -> None:
    signs = {(x > 0, y > 0) for x, y in (w.position_m for w in shipped("yard-loop").waypoints) if x and y}
    assert len(signs) == 4


def test_a_missing_mission_says_so(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"no-such\.yaml: there is no such file"):
        load_mission(tmp_path / "no-such.yaml")


def test_a_problem_names_the_file_as_it_was_given(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text("name: n\npolicy: p\nwaypoints: []\n")
    with pytest.raises(MissionError) as caught:
        load_mission(path)
    assert str(caught.value) == f"{path}:3:12: waypoints: has 0 entries; at least 1 are needed"


def test_loading_a_mission_loads_nothing_heavy() -> None:
    code = (
        "import sys; from pathlib import Path; from waypointctl.mission.files import load_mission;"
        f"load_mission(Path({str(SHIPPED[0])!r}));"
        "print([m for m in ('numpy', 'mujoco', 'torch', 'mcap', 'rich', 'typer', 'difflib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@settings(deadline=None, max_examples=12)
@given(missions())
def test_any_mission_is_dumped_and_read_back(mission: Mission) -> None:
    text = dump_mission(mission)
    assert parse_mission(text.encode(), "dump") == mission


@settings(deadline=None, max_examples=40)
@given(st.data())
def test_a_damaged_mission_is_read_or_refused_with_its_place(data: st.DataObject) -> None:
    source = bytearray(data.draw(st.sampled_from([path.read_bytes() for path in SHIPPED])))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(source) - 1))
        source[at : at + data.draw(st.integers(0, 3))] = data.draw(
            st.sampled_from(list(b":,[]{}-&*!# \n\t09.x\xff")).map(lambda b: bytes([b]))
        )
    try:
        parse_mission(bytes(source), "m.yaml")
    except MissionError as error:
        lines = str(error).splitlines()
        assert all(line.startswith("m.yaml:") for line in lines)
