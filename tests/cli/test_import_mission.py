from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.flying import Program
from waypointctl.mission.files import load_mission

LINE = {"type": "LineString", "coordinates": [[8.5456, 47.3977], [8.5457, 47.3977]]}


@pytest.fixture
def line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "line.geojson"
    path.write_text(json.dumps(LINE))
    monkeypatch.chdir(tmp_path)
    return path


def test_a_line_goes_to_stdout_or_to_a_file_beside_which_the_policy_is_named(line: Path, program: Program) -> None:
    code, told, _ = program("import", "line.geojson")
    assert code == 0
    assert 'policy: "ant-waypoint"' in told
    (line.parent / "missions").mkdir()
    code, said, _ = program("import", "line.geojson", "--out", "missions/line.yaml", "--policy", "mine")
    assert (code, said) == (
        0,
        "missions/line.yaml: 1 waypoint; `waypointctl validate missions/line.yaml` checks it\n",
    )
    assert load_mission(line.parent / "missions" / "line.yaml").policy_path.resolve() == line.parent / "mine"
    assert program("fmt", "--check", "missions/line.yaml")[0] == 0


@pytest.mark.parametrize(
    ("policy", "written"),
    [("known", "known"), ("policies/known", "known"), ("ant-waypoint", "ant-waypoint"), ("mine", "{cwd}/mine")],
)
def test_a_mission_from_stdout_finds_its_policy_from_any_folder(
    line: Path, program: Program, make_policy: Callable[..., Path], policy: str, written: str
) -> None:
    make_policy(line.parent / "mine")
    make_policy(line.parent / "policies" / "known")
    told = program("import", "line.geojson", "--policy", policy)[1]
    assert f'policy: "{written.format(cwd=line.parent)}"' in told
    (line.parent / "missions").mkdir()
    (line.parent / "missions" / "red.yaml").write_text(told)
    assert (load_mission(line.parent / "missions" / "red.yaml").policy_path / "manifest.json").is_file()


def test_a_policy_that_is_not_there_is_warned_of(line: Path, program: Program) -> None:
    warning = "warning: m.yaml: the policy '{}' is not there: {}. A policy is a folder with manifest.json, or a name."
    code, _, said = program("import", "line.geojson", "--out", "m.yaml", "--policy", "mine")
    assert code == 0
    assert said.startswith(warning.format("mine", "folder not found"))
    code, _, said = program("import", "line.geojson", "--out", "m.yaml", "--force", "--policy", "m.yaml")
    assert code == 0
    assert said.startswith(warning.format("m.yaml", "is a file, not a folder"))
    assert program("import", "line.geojson", "--out", "m.yaml", "--force")[2] == ""  # the default is always there
    (line.parent / "mine").mkdir()
    assert program("import", "line.geojson", "--out", "m.yaml", "--force", "--policy", "mine")[2] == ""


def test_a_file_that_is_there_is_replaced_on_request_alone(line: Path, program: Program) -> None:
    (line.parent / "m.yaml").write_text("mine")
    code, _, said = program("import", "line.geojson", "--out", "m.yaml")
    assert (code, said) == (2, "error: m.yaml: already exists\n  Use --force to replace it, or give another --out.\n")
    assert (line.parent / "m.yaml").read_text() == "mine"
    assert program("import", "line.geojson", "--out", "m.yaml", "--force")[0] == 0
    assert load_mission(line.parent / "m.yaml").mission.name == "line"


def test_an_origin_is_taken_from_the_command_line(line: Path, program: Program) -> None:
    code, told, _ = program("import", "line.geojson", "--origin", "47.3976,8.5456")
    assert code == 0
    assert "x is east and y is north of 47.3976000, 8.5456000." in told
    assert "start:\n  position: [0 m, 11.1" in told


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["line.geojson", "--origin", "47"], "--origin: '47' is not two numbers"),
        (["line.geojson", "--origin", "97,8"], "--origin: '97,8' is not a latitude within -90 and 90"),
        (["line.geojson", "--origin", "nan,8"], "--origin: 'nan,8' is not a latitude within -90 and 90"),
        (["line.geojson", "--out", "no/such/m.yaml"], "no/such/m.yaml: the mission cannot be written"),
        (["missing.plan"], "missing.plan: there is no such file"),
        (["line.kml"], "line.kml: there is no such file"),
        (["line.geojson", "--body", "pluto"], "--body: 'pluto' is not a body, and not a radius with its unit"),
        (["line.geojson", "--body", "1 m"], "--body: '1 m' is not a radius within 10 and 100000 km"),
        (
            ["metres.csv", "--origin", "47,8"],
            "metres.csv: has x and y in metres; --origin and --body are for latitudes",
        ),
        (["metres.csv", "--body", "moon"], "metres.csv: has x and y in metres; --origin and --body are for latitudes"),
    ],
)
def test_what_is_wrong_is_said_and_exits_with_2(
    line: Path, program: Program, arguments: list[str], problem: str
) -> None:
    (line.parent / "metres.csv").write_text("x,y\n0,0\n1,1\n")
    code, told, said = program("import", *arguments)
    assert (code, told) == (2, "")
    assert said.startswith(f"error: {problem}")


@pytest.mark.parametrize(
    ("body", "metres", "on"),
    [("earth", "7.549", ""), ("moon", "2.053", " on the Moon"), ("1737.4 km", "2.053", " on a sphere of 1737.4 km")],
)
def test_a_body_is_taken_from_the_command_line(line: Path, program: Program, body: str, metres: str, on: str) -> None:
    code, told, _ = program("import", "line.geojson", "--body", body)
    assert code == 0
    assert f"north of 47.3977000, 8.5456000{on}.\n" in told
    assert f"  - {{position: [{metres} m, 0 m]}}" in told


def test_what_is_left_out_and_what_else_is_worth_knowing_is_said(line: Path, program: Program) -> None:
    both = {"type": "GeometryCollection", "geometries": [LINE, {"type": "Point", "coordinates": [8.5, 47.3]}]}
    (line.parent / "both.plan").write_text(json.dumps(both))
    (line.parent / "p").mkdir()
    code, _, said = program("import", "both.plan", "--policy", "p")
    assert code == 0
    assert said == "note: both.plan is GeoJSON by its content, and read as that\nleft out: 1 Point\n"
