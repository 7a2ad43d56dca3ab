from __future__ import annotations

import json
import os
import signal
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.cli.flying import Program, start
from waypointctl.log.reader import open_log

WALKING = """\
name: walking
policy: still
waypoints: [{name: away, position: [50 m, 50 m], timeout: 1 h}]
"""
BROKEN = "name: n\npolicy: p\nwaypoint: []\n"


def test_several_missions_are_flown_in_turn_with_a_table_at_the_end(yard: Path, program: Program) -> None:
    (yard / "other.yaml").write_text((yard / "easy.yaml").read_text().replace("name: easy", "name: other"))
    code, told, said = program("run", "easy.yaml", "other.yaml")
    assert code == 0
    head, _, easy, other, _, counts = told.strip().splitlines()
    assert head.split() == ["mission", "outcome", "reached", "time", "[s]", "log"]
    assert easy.split()[:3] == ["easy", "success", "2/2"]
    assert other.split()[-1] == "logs/other.mcap"
    assert counts == "2 succeeded"
    assert said.splitlines()[0].startswith("easy.yaml: success: 2 of 2 waypoints reached in ")
    assert open_log(yard / "logs" / "other.mcap")


def test_all_that_can_be_flown_are_and_the_exit_code_tells_the_worst(yard: Path, program: Program) -> None:
    (yard / "broken.yaml").write_text(BROKEN)
    assert program("run", "far.yaml", "easy.yaml")[0] == 1
    code, told, said = program("run", "broken.yaml", "far.yaml", "missing.yaml", "easy.yaml", "--junit", "out.xml")
    assert code == 2
    assert told.splitlines()[-1] == "2 invalid files, 1 failed, 1 succeeded"
    assert "\nbroken.yaml:3:1: waypoint: unknown key" in f"\n{said}"
    assert "missing.yaml: missing.yaml" not in said
    assert "broken.yaml: broken.yaml" not in said
    root = ElementTree.parse(yard / "out.xml").getroot()
    assert {"tests": "4", "failures": "1", "errors": "2"}.items() <= root.attrib.items()
    cases = {case.get("name"): [child.tag for child in case] for case in root.iter("testcase")}
    assert cases == {
        "broken.yaml": ["error"],
        "far.yaml": ["failure", "system-out"],
        "missing.yaml": ["error"],
        "easy.yaml": ["system-out"],
    }


def test_json_is_one_object_of_all_missions(yard: Path, program: Program) -> None:
    code, told, _ = program("run", "easy.yaml", "missing.yaml", "--json")
    assert code == 2
    easy, missing = json.loads(told)["missions"]
    assert (easy["file"], easy["mission"], easy["outcome"]) == ("easy.yaml", "easy", "success")
    assert easy["log"] == "logs/easy.mcap"
    assert missing == {
        "file": "missing.yaml",
        "outcome": "error",
        "reason": "missing.yaml: there is no such file",
    }


def test_a_report_of_one_mission_leaves_its_json_and_its_log_as_they_are(yard: Path, program: Program) -> None:
    (yard / "out.xml").write_text("<?xml version='1.0'?><old/>")
    _, alone, _ = program("run", "easy.yaml", "--json", "--out", "a.mcap")
    code, told, _ = program("run", "easy.yaml", "--json", "--out", "b.mcap", "--junit", "out.xml")
    assert code == 0
    reported, before = json.loads(told), json.loads(alone)
    assert reported.pop("file") == "easy.yaml"
    assert reported | {"log": "a.mcap"} == before
    assert (yard / "b.mcap").read_bytes() == (yard / "a.mcap").read_bytes()


def test_a_seed_and_a_policy_are_for_all(yard: Path, program: Program) -> None:
    _, told, _ = program("run", "easy.yaml", "far.yaml", "--json", "--seed", "9", "--policy", "still")
    assert [mission["seed"] for mission in json.loads(told)["missions"]] == [9, 9]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["easy.yaml", "far.yaml", "--out", "a.mcap"], "--out: cannot be used with several missions."),
        (["easy.yaml", "far.yaml", "--console"], "--console: cannot be used with several missions."),
        (["easy.yaml", "--dry-run", "--out", "a.mcap"], "--out: cannot be used with --dry-run."),
        (["easy.yaml", "--junit", "o.xml", "--rate", "2"], "--rate: cannot be used with --junit."),
        (["easy.yaml", "--junit", "no/o.xml"], "no/o.xml: the report cannot be written"),
        (["easy.yaml", "--junit", "far.yaml"], "far.yaml: already exists and is not an XML file"),
        (["--resume", "a.mcap", "--junit", "o.xml"], "--junit: cannot be used with --resume"),
    ],
)
def test_what_does_not_go_together_is_refused_before_anything_is_flown(
    yard: Path, program: Program, arguments: list[str], problem: str
) -> None:
    code, told, said = program("run", *arguments)
    assert (code, told) == (2, "")
    assert problem in " ".join(said.replace("│", "").split())
    assert not (yard / "logs").exists()


def test_an_interruption_ends_the_flight_and_leaves_the_rest(yard: Path) -> None:
    (yard / "walking.yaml").write_text(WALKING)
    flying = start(yard, "run", "walking.yaml", "easy.yaml", "--junit", "out.xml")
    part = yard / "logs" / "walking.mcap.part"
    until = time.monotonic() + 60
    while (not part.exists() or part.stat().st_size == 0) and time.monotonic() < until:
        time.sleep(0.02)
    os.kill(flying.pid, signal.SIGINT)
    assert flying.wait(60) == 130
    root = ElementTree.parse(yard / "out.xml").getroot()
    assert [[child.tag for child in case] for case in root.iter("testcase")] == [["error", "system-out"], ["skipped"]]
    assert open_log(yard / "logs" / "walking.mcap")
    assert not (yard / "logs" / "easy.mcap").exists()
