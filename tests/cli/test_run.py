from __future__ import annotations

import hashlib
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.flying import EASY, Program, start
from waypointctl.log.messages import Event, EventKind
from waypointctl.log.reader import open_log


def test_a_flight_is_logged_and_summed_up(yard: Path, program: Program) -> None:
    code, out, err = program("run", "easy.yaml")
    assert code == 0
    log = yard / "logs" / "easy.mcap"
    assert hashlib.sha256(log.read_bytes()).hexdigest() in out
    assert "logs/easy.mcap" in out
    assert out.strip().startswith("success: 2 of 2 waypoints reached")
    assert "there [/bold]" in out
    assert "times real time" in out
    assert list(log.parent.iterdir()) == [log]
    assert "easy" not in err.splitlines()[-1]


def test_without_a_terminal_each_happening_is_a_line_with_its_time_and_clock(yard: Path, program: Program) -> None:
    _, _, err = program("run", "easy.yaml")
    lines = err.splitlines()
    assert all(
        re.fullmatch(r" *\d+\.\d{3} s  (robot|operator)  .+", line.replace("robot   ", "robot")) for line in lines
    )
    assert "     0.520 s  robot     here reached" in lines
    # The hold of 1 s ends at 1.52 s, the next waypoint is found reached a control step later; half a second brings it.
    assert "     1.520 s  robot     hold at here completed" in lines
    assert "     1.540 s  robot     command 1 completed" in lines
    assert "     2.040 s  operator  ack received: command 1 completed, 0.500 s ago" in lines
    assert "\x1b" not in err


def test_json_is_one_object_on_stdout(yard: Path, program: Program) -> None:
    code, out, err = program("run", "easy.yaml", "--json", "--out", "here.mcap")
    found = json.loads(out)
    assert code == 0
    assert found.pop("summary")["outcome"] == "success"
    assert found == {
        "mission": "easy",
        "outcome": "success",
        "reason": "2 of 2 waypoints reached in 2.04 s",
        "waypoints_reached": 2,
        "waypoints_total": 2,
        "sim_time_s": 2.04,
        "seed": 4,
        "log": "here.mcap",
        "log_sha256": hashlib.sha256((yard / "here.mcap").read_bytes()).hexdigest(),
        "pictures": 0,
    }
    assert "success: 2 of 2 waypoints reached" in err


def test_a_mission_that_fails_exits_with_1(yard: Path, program: Program) -> None:
    code, out, _ = program("run", "far.yaml", "--json")
    found = json.loads(out)
    assert (code, found["outcome"], found["waypoints_reached"]) == (1, "failure", 0)
    assert open_log(yard / found["log"]).is_complete


def test_each_flight_gets_a_name_of_its_own(yard: Path, program: Program) -> None:
    logs = [json.loads(program("run", "easy.yaml", "--json")[1])["log"] for _ in range(3)]
    assert logs == ["logs/easy.mcap", "logs/easy-2.mcap", "logs/easy-3.mcap"]


def test_a_name_that_a_killed_flight_holds_is_left_to_it(yard: Path, program: Program) -> None:
    (yard / "logs").mkdir()
    (yard / "logs" / "easy.mcap.part").write_bytes(b"evidence")
    assert json.loads(program("run", "easy.yaml", "--json")[1])["log"] == "logs/easy-2.mcap"
    assert (yard / "logs" / "easy.mcap.part").read_bytes() == b"evidence"


def test_the_same_seed_flies_the_same_and_another_does_not(yard: Path, program: Program) -> None:
    def sha(*arguments: str) -> str:
        return str(json.loads(program("run", "easy.yaml", "--json", *arguments)[1])["log_sha256"])

    assert sha() == sha("--seed", "4")
    assert sha() != sha("--seed", "5")
    assert json.loads(program("run", "easy.yaml", "--json", "--seed", "5")[1])["seed"] == 5


def test_a_log_that_is_there_is_not_replaced_unless_asked_to(yard: Path, program: Program) -> None:
    precious = b"\x89MCAP0\r\n, a flight"
    (yard / "kept.mcap").write_bytes(precious)
    code, out, err = program("run", "easy.yaml", "--out", "kept.mcap")
    assert (code, out) == (2, "")
    assert err == "error: kept.mcap: already exists\n  Use --force to replace it, or give another --out.\n"
    assert (yard / "kept.mcap").read_bytes() == precious
    assert program("run", "easy.yaml", "--out", "kept.mcap", "--force")[0] == 0
    assert open_log(yard / "kept.mcap").is_complete


def test_force_does_not_replace_the_mission(yard: Path, program: Program) -> None:
    before = (yard / "easy.yaml").read_bytes()
    code, out, err = program("run", "easy.yaml", "--out", "easy.yaml", "--force")
    assert (code, out) == (2, "")
    assert err == "error: easy.yaml: is not a log; --force replaces only logs\n  Give another --out.\n"
    assert "--force" not in program("run", "easy.yaml", "--out", "easy.yaml")[2]
    assert (yard / "easy.yaml").read_bytes() == before
    assert not (yard / "easy.yaml.part").exists()


def test_the_log_of_a_flight_under_way_is_not_written_into(yard: Path, program: Program) -> None:
    (yard / "busy.mcap.part").write_bytes(b"another flight")
    code, _, err = program("run", "easy.yaml", "--out", "busy.mcap")
    assert code == 2
    assert "busy.mcap.part already exists" in err
    assert (yard / "busy.mcap.part").read_bytes() == b"another flight"


@pytest.mark.parametrize("out", ["none/such.mcap", ".", "easy.yaml/log.mcap", f"{'x' * 300}.mcap"])
def test_a_place_that_cannot_be_written_is_refused_before_the_flight(yard: Path, program: Program, out: str) -> None:
    code, text, err = program("run", "easy.yaml", "--out", out)
    assert (code, text) == (2, "")
    assert err.startswith(f"error: {out}: ")
    assert len(err.splitlines()) == 2


def test_logs_cannot_be_a_folder(yard: Path, program: Program) -> None:
    (yard / "logs").write_text("a file")
    code, _, err = program("run", "easy.yaml")
    assert code == 2
    assert "logs/easy.mcap: cannot be written" in err


@pytest.mark.parametrize("arguments", [("nowhere.yaml",), ("easy.yaml", "--policy", "nowhere")])
def test_what_is_not_there_is_said(yard: Path, program: Program, arguments: tuple[str, ...]) -> None:
    code, out, err = program("run", *arguments)
    assert (code, out) == (2, "")
    assert err.startswith("error: nowhere")
    assert not (yard / "logs").exists()


def test_a_policy_for_another_layout_is_refused_and_leaves_no_log(yard: Path, program: Program) -> None:
    manifest = yard / "still" / "manifest.json"
    manifest.write_text(manifest.read_text().replace('"layout": "egocentric"', '"layout": "state_goal"'))
    code, _, err = program("run", "easy.yaml", "--out", "log.mcap")
    assert code == 2
    assert err.startswith("error: ")
    assert "Traceback" not in err
    assert not list(yard.glob("log.mcap*"))


@pytest.mark.parametrize("rate", ["0", "-1", "nan", "inf"])
def test_a_rate_is_a_number_above_0(yard: Path, program: Program, rate: str) -> None:
    code, _, err = program("run", "easy.yaml", "--rate", rate)
    assert code == 2
    assert "above 0" in err


def test_a_rate_holds_the_flight_back(yard: Path, program: Program) -> None:
    _, out, _ = program("run", "easy.yaml", "--rate", "2")
    match = re.search(r"wall time  ([\d.]+) s for 2\.04 s of simulation", out)
    assert match
    assert math.isclose(float(match[1]), 1.0, abs_tol=0.5)
    # Held back or not, it is the same flight.
    held, free = (json.loads(program("run", "easy.yaml", "--json", *more)[1]) for more in (("--rate", "8"), ()))
    assert held["log_sha256"] == free["log_sha256"]


def test_the_operator_ends_the_mission_in_the_log(yard: Path, program: Program) -> None:
    program("run", "easy.yaml", "--out", "log.mcap")
    *_, last = open_log(yard / "log.mcap").messages()
    assert isinstance(last, Event)
    assert last.kind is EventKind.MISSION_ENDED


def test_whoever_reads_the_lines_may_go_away(yard: Path) -> None:
    code = "from waypointctl.cli.main import main; main()"
    command = f'"{sys.executable}" -c "{code}" run easy.yaml --out log.mcap 2>&1 >/dev/null | head -n 1'
    done = subprocess.run(["bash", "-c", command], cwd=yard, capture_output=True, text=True, check=True)
    assert done.stdout == "     0.000 s  operator  mission easy started\n"
    assert open_log(yard / "log.mcap").is_complete


@pytest.mark.parametrize("more", [("--json",), ()])
def test_a_full_disk_under_the_answer_is_one_line(yard: Path, more: tuple[str, ...]) -> None:
    with Path("/dev/full").open("wb") as full:
        flight = start(yard, "run", "easy.yaml", *more, stdout=full.fileno(), stderr=subprocess.PIPE)
        _, err = flight.communicate(timeout=60)
    assert flight.returncode == 2
    assert err.splitlines()[-1] == b"error: the answer cannot be written: No space left on device"
    assert b"Traceback" not in err
    assert b"Exception ignored" not in err


def test_whoever_reads_the_answer_may_go_away(yard: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    flight = start(yard, "run", "easy.yaml", "--json", stdout=writing, stderr=subprocess.PIPE)
    os.close(writing)
    _, err = flight.communicate(timeout=60)
    assert flight.returncode == 0
    assert b"Traceback" not in err
    assert b"Exception ignored" not in err


def test_a_terminal_that_cannot_show_a_name_does_not_end_the_flight(yard: Path) -> None:
    (yard / "foreign.yaml").write_text((yard / "easy.yaml").read_text().replace("name: here", "name: 近い"))
    flight = start(
        yard, "run", "foreign.yaml", stdout=subprocess.PIPE, stderr=subprocess.PIPE, PYTHONIOENCODING="latin-1"
    )
    out, err = flight.communicate(timeout=60)
    assert flight.returncode == 0
    assert b"success: 2 of 2 waypoints reached" in out
    assert rb"robot     \u8fd1\u3044 reached" in err


def test_a_policy_that_is_not_there_is_told_with_its_place_in_the_mission(yard: Path, program: Program) -> None:
    (yard / "nobody.yaml").write_text(EASY.replace("policy: still", "policy: ./nobody"))
    line = EASY[: EASY.index("policy:")].count("\n") + 1
    code, out, err = program("run", "nobody.yaml", "--json")
    assert (code, json.loads(out)["error"]["where"]) == (2, f"nobody.yaml:{line}:9")
    assert err.startswith(
        f"error: nobody.yaml:{line}:9: policy: nobody: folder not found\n  The mission names './nobody', "
    )
    assert f"relative to its own folder {yard}. " in err
    assert "There is ant-waypoint (shipped with waypointctl)." in err
    assert "`waypointctl run nobody.yaml --policy POLICY` flies another one." in err
    assert program("run", "nobody.yaml", "--policy", "still")[0] == 0
    code, _, err = program("run", "easy.yaml", "--policy", "nobody")
    assert (code, err.splitlines()[0]) == (2, "error: nobody: folder not found")
