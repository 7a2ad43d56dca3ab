"""A log where a mission is wanted, a mission where a log is, another tool's plan: which command takes it is said."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.flying import Program
from tests.log.fake_flight import flight, header
from waypointctl.log.writer import LogWriter

LOG = "this is a log: `waypointctl replay {0}` shows it, `waypointctl run --resume {0}` continues it"
PLAN = "this is {1}; import it first: `waypointctl import {0} --out {2}`"
MISSION = "`waypointctl run {0}` flies a mission and writes its log, `waypointctl validate {0}` checks it."


@pytest.fixture
def kinds(yard: Path) -> Path:
    """A folder with a file of each kind."""
    for name in ("flight.mcap", "my flight.mcap", "log.yaml"):
        with LogWriter(yard / name, header()) as sink:
            for message in flight(1):
                sink(message)
    (yard / "yard.plan").write_text(json.dumps({"fileType": "Plan", "version": 1}))
    (yard / "Line.GeoJSON").write_text(json.dumps({"type": "LineString", "coordinates": []}))
    return yard


@pytest.mark.parametrize("command", ["run", "validate", "fmt", "train"])
@pytest.mark.parametrize(
    ("log", "quoted"),
    [("flight.mcap", "flight.mcap"), ("my flight.mcap", "'my flight.mcap'"), ("log.yaml", "log.yaml")],
)
def test_a_log_for_a_mission(kinds: Path, program: Program, command: str, log: str, quoted: str) -> None:
    code, out, err = program(command, log)
    assert code == 2
    assert f"{log}: {LOG.format(quoted)}\n" in out + err


@pytest.mark.parametrize("command", ["run", "validate", "fmt"])
@pytest.mark.parametrize(
    ("plan", "kind", "mission"),
    [("yard.plan", "a QGroundControl plan", "yard.yaml"), ("Line.GeoJSON", "a GeoJSON file", "Line.yaml")],
)
def test_a_plan_for_a_mission(kinds: Path, program: Program, command: str, plan: str, kind: str, mission: str) -> None:
    before = (kinds / plan).read_bytes()
    code, out, err = program(command, plan)
    assert code == 2
    assert f"{plan}: {PLAN.format(plan, kind, mission)}\n" in out + err
    assert (kinds / plan).read_bytes() == before


@pytest.mark.parametrize("command", [["info"], ["replay"], ["replay", "--verify"], ["run", "--resume"]])
def test_a_mission_or_a_plan_for_a_log(kinds: Path, program: Program, command: list[str]) -> None:
    code, out, err = program(*command, "easy.yaml")
    assert (code, out) == (2, "")
    assert err == f"error: easy.yaml: is not an MCAP file\n  {MISSION.format('easy.yaml')}\n"
    code, _, err = program(*command, "yard.plan")
    assert code == 2
    assert "import it first: `waypointctl import yard.plan --out yard.yaml`" in err


def test_a_log_among_missions_is_one_of_several_that_are_broken(kinds: Path, program: Program) -> None:
    code, out, err = program("run", "easy.yaml", "flight.mcap")
    assert code == 2
    assert LOG.format("flight.mcap") in err
    assert "1 succeeded, 1 invalid file" in out
