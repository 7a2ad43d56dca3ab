from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from waypointctl.cli.app import app
from waypointctl.mission.link import Way

ROOT = Path(__file__).parents[2]
SHIPPED = sorted(str(path) for path in (ROOT / "missions").glob("*.yaml"))
BAD = "name: n\npolicy: p\nsead: 3\nwaypoints:\n  - {position: [1 m, 2 m], timeout: 20}\n"


@pytest.fixture
def bad(tmp_path: Path) -> Path:
    path = tmp_path / "bad.yaml"
    path.write_text(BAD)
    return path


def test_says_ok_of_every_shipped_mission() -> None:
    result = CliRunner().invoke(app, ["validate", *SHIPPED])
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert [line.split(":")[0] for line in lines[::2]] == [f"OK {path}" for path in SHIPPED]
    assert all(
        line.startswith("   expected duration ") and "ant-waypoint in the suite region" in line for line in lines[1::2]
    )


def test_an_ok_line_tells_what_will_be_flown(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: p\nwaypoints: [[3, 4], [3, 10]]\nlink: {up: {delay: 2 s, jitter: 10 ms}}\n")
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert result.stdout == (
        f"OK {path}: dog, 2 waypoints, 11.0 m, link 2 s +- 0.01 s up, 0 s down, autonomy mission\n"
        "   expected duration 7.5 s at 2.00 m/s (assumed: no evaluation of p states its speed); other autonomies: "
        "waypoint 9.5 s, heading 40.4 s, joint falls\n"
    )
    assert result.stderr == ""


@pytest.mark.parametrize(
    ("link", "text"),
    [
        ("{preset: iss, loss: 1 %}", "link iss: 3.5 s +- 0.5 s with 1 % lost each way"),
        (
            "{up: {rate: 1 kbit/s, duplicate: 2 %}, down: {loss: {p: 0.1, r: 0.3}, keep_order: false}}",
            "link 0 s with 2 % doubled and 1 kbit/s up, 0 s with 25 % lost in bursts and the order not kept down",
        ),
        (
            "{delay_table: [{at: 0 s, delay: 3 s}, {at: 1 h, delay: 4 s}], windows: [{from: 0 s, to: 1 s}]}",
            "link 3 to 4 s with 1 window each way",
        ),
        (
            "{delay: 1 s, jitter: 2 s, jitter_distribution: normal, "
            "windows: [{from: 0 s, to: 1 s}], windows_every: 1 h}",
            "link 1 s +- 2 s (normal) with 1 window every 3600 s each way",
        ),
        (
            "{contact_plan: {file: plan, from_node: 1, to_node: 2}, jitter_file: j}",
            "link the delays and contacts of plan + j each way",
        ),
        (
            "{contact_plan: {file: plan, from_node: 1, to_node: 2}, delay: 1 s}",
            "link 1 s with the contacts of plan each way",
        ),
    ],
)
def test_an_ok_line_tells_what_the_link_does(tmp_path: Path, link: str, text: str) -> None:
    (tmp_path / "plan").write_text("a contact +0 +9 1 2 1\na contact +0 +9 2 1 1\na range +0 +9 1 2 1\n")
    (tmp_path / "j").write_text("0.1\n")
    path = tmp_path / "m.yaml"
    path.write_text(f"name: dog\npolicy: .\nwaypoints: [[3, 4]]\nlink: {link}\n")
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert f"{text}, autonomy mission" in result.stdout


def test_a_mistake_in_a_file_that_a_mission_refers_to_is_told_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "j").write_text("soon\n")
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: .\nwaypoints: [[3, 4]]\nlink: {jitter_file: j}\n")
    result = CliRunner().invoke(app, ["validate", "--json", str(path)])
    assert result.exit_code == 2
    problem = {
        "file": str(tmp_path / "j"),
        "line": 1,
        "column": 1,
        "path": "",
        "problem": "'soon' is not a number of seconds",
    }
    assert json.loads(result.stdout)["missions"][0]["problems"] == [problem]


def test_a_policy_that_is_not_there_is_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: nowhere\nwaypoints: [[3, 4]]\n")
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert result.exit_code == 0
    ok, _ = result.stdout.splitlines()
    assert ok == f"OK {path}: dog, 1 waypoint, 5.0 m, link without delay, autonomy mission"
    assert result.stderr.startswith(
        f"warning: {path}:2:9: policy: there is no folder {tmp_path / 'nowhere'}. A policy is"
    )


def test_lists_every_problem_of_every_file_and_exits_with_2(bad: Path) -> None:
    missing = bad.parent / "missing.yaml"
    result = CliRunner().invoke(app, ["validate", str(bad), SHIPPED[0], str(missing)])
    assert result.exit_code == 2
    lines = result.stdout.splitlines()
    assert lines[:2] == [
        f"{bad}:3:1: sead: unknown key; did you mean 'seed'?",
        f"{bad}:5:37: waypoints[0].timeout: 20 has no unit; write 'timeout: 20 s' or 'timeout_s: 20'",
    ]
    assert lines[2].startswith(f"OK {SHIPPED[0]}: ")
    assert lines[4:] == [f"{missing}: there is no such file"]


def test_what_may_go_wrong_is_a_warning_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    path = tmp_path / "m.yaml"
    path.write_text(
        "name: dog\npolicy: p\nexpect: {max_time: 2 s}\nwaypoints:\n  - [3, 4]\n"
        "  - {position: [3 m, 40 m], timeout: 9 s}\nlink:\n  rate: 1 kbit/s\n"
    )
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert result.exit_code == 0
    assert result.stderr.splitlines() == [
        f"warning: {path}:3:10: expect.max_time: 2 s is shorter than the expected duration, about 13.4 s",
        f"warning: {path}:6:29: waypoints[1].timeout: the leg to WP2 takes about 18.0 s; its timeout is 9 s: "
        "will not be completed",
        f"warning: {path}:8:3: link.rate: telemetry comes to 3560 bit/s, and the link down carries 1000: what is "
        "too much waits, and acknowledgements behind it; once the queue is full they are lost",
    ]
    assert CliRunner().invoke(app, ["validate", "--strict", str(path)]).exit_code == 1
    (record,) = json.loads(CliRunner().invoke(app, ["validate", "--json", str(path)]).stdout)["missions"]
    assert [warning["kind"] for warning in record["warnings"]] == ["max_time", "timeout", "rate"]
    assert record["warnings"][0]["place"] == f"{path}:3:10"


def test_strict_minds_only_warnings(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: p\nwaypoints: [[3, 4]]\n")
    assert CliRunner().invoke(app, ["validate", "--strict", str(path)]).exit_code == 0


def test_json_is_one_object_and_nothing_else(bad: Path) -> None:
    result = CliRunner().invoke(app, ["validate", "--json", SHIPPED[0], str(bad)])
    assert result.exit_code == 2
    assert result.stderr == ""
    report = json.loads(result.stdout)
    assert report["ok"] is False
    good, wrong = report["missions"]
    assert (good["ok"], good["name"], good["problems"]) == (True, Path(SHIPPED[0]).stem, [])
    assert wrong == {
        "file": str(bad),
        "ok": False,
        "problems": [
            {"file": str(bad), "line": 3, "column": 1, "path": "sead", "problem": "unknown key; did you mean 'seed'?"},
            {
                "file": str(bad),
                "line": 5,
                "column": 37,
                "path": "waypoints[0].timeout",
                "problem": "20 has no unit; write 'timeout: 20 s' or 'timeout_s: 20'",
            },
        ],
    }


def test_json_of_a_good_mission_has_what_the_ok_line_has(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: p\nwaypoints: [[3, 4]]\nlink: {delay: 2 s}\n")
    result = CliRunner().invoke(app, ["validate", "--json", str(path)])
    assert result.exit_code == 0
    way = Way(delay_s=2.0).model_dump(mode="json")
    assert {"delay_s": 2.0, "jitter_s": 0.0, "loss": 0.0, "rate_bps": None}.items() <= way.items()
    way_s = (5 - 0.5 / 0.8) / 2  # to where the waypoint's box begins
    once_s = 0.35 + way_s + 4
    times = {"mission": (once_s, 1), "waypoint": (once_s, 1), "heading": (way_s + 7 * 4.35, 7), "joint": (None, 1)}
    assert json.loads(result.stdout) == {
        "ok": True,
        "missions": [
            {
                "file": str(path),
                "ok": True,
                "problems": [],
                "name": "dog",
                "waypoints": 1,
                "path_length_m": 5.0,
                "link": {"preset": None, "up": way, "down": way},
                "autonomy": "mission",
                "policy": str(tmp_path / "p"),
                "policy_found": True,
                "speed": {"mps": 2.0, "source": "assumed: no evaluation of p states its speed"},
                "expected_time_s": pytest.approx(once_s),
                "expected_time_is_lower_bound": False,
                "expected_success": True,
                "expected_failure": "",
                "probability": 1.0,
                "expected": [
                    {
                        "autonomy": autonomy,
                        "time_s": pytest.approx(time_s),
                        "exchanges": exchanges,
                        "blocked": None,
                        "falls": autonomy == "joint",  # 4 s of round trip
                        "fails": "",
                    }
                    for autonomy, (time_s, exchanges) in times.items()
                ],
                "not_counted": [],
                "warnings": [],
            }
        ],
    }


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"a: [", b"- 1", b"[" * 5000, b"a: &x [*x]"])
def test_no_content_leads_to_a_traceback(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "m.yaml"
    path.write_bytes(content)
    command = [sys.executable, "-c", "from waypointctl.cli.main import main; main()", "validate", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout.startswith(f"{path}:1:")
    assert done.stderr == ""


def test_validating_loads_no_simulator(tmp_path: Path) -> None:
    code = (
        "import sys; from waypointctl.cli.app import app\n"
        f"app(['validate', {SHIPPED[0]!r}], standalone_mode=False)\n"
        "print([name for name in ('mujoco', 'onnxruntime', 'torch', 'rich') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("\n[]\n")


def test_another_policy_may_be_expected_to_fly(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: gone\nwaypoints: [[3, 4]]\n")
    policy = ROOT / "policies" / "ant-waypoint"
    result = CliRunner().invoke(app, ["validate", "--strict", str(path), "--policy", str(policy)])
    assert (result.exit_code, result.stderr) == (0, "")
    assert "mean speed of ant-waypoint in the suite region" in result.stdout
    result = CliRunner().invoke(app, ["validate", "--json", str(path), "--policy", str(policy)])
    (record,) = json.loads(result.stdout)["missions"]
    assert (record["policy"], record["policy_found"]) == (str(policy), True)


def test_one_that_is_not_there_is_refused(tmp_path: Path) -> None:
    argv = ["validate", SHIPPED[0], "--policy", str(tmp_path / "gone")]
    run = subprocess.run([sys.executable, "-m", "waypointctl", *argv], capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert "gone: no such folder\n  A policy is a folder with manifest.json, or a name. There is " in run.stderr


def test_one_wrong_reference_is_one_problem(tmp_path: Path) -> None:
    (tmp_path / "p.ionrc").write_text(
        "a contact 2026/11/22-10:00:00 2026/11/22-10:00:20 1 2 99\na contact +0 +20 2 1 99\na range +0 +20 1 2 1\n"
    )
    path = tmp_path / "m.yaml"
    head = "name: dog\npolicy: p\nwaypoints: [[3, 4]]\nlink: {contact_plan: {file: p.ionrc, from_node: 1, to_node: 2"
    path.write_text(f"{head}}}}}\n")
    (line,) = CliRunner().invoke(app, ["validate", str(path)]).stdout.splitlines()
    assert "p.ionrc:1:11: 2026/11/22-10:00:00 is an absolute time, and the mission has no date" in line
    path.write_text(f'{head}, reference: "2026-11-22"}}}}\n')
    (line,) = CliRunner().invoke(app, ["validate", str(path)]).stdout.splitlines()
    assert "link.contact_plan.reference: '2026-11-22' is not a moment" in line


def test_a_duration_without_losses_is_a_lower_bound(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    path = tmp_path / "m.yaml"
    head = "name: dog\npolicy: p\nwaypoints: [[3, 4]]\nlink: {delay: 1 s, loss: 1 %}\n"
    path.write_text(head)
    assert "   expected duration at least " in CliRunner().invoke(app, ["validate", str(path)]).stdout
    (record,) = json.loads(CliRunner().invoke(app, ["validate", "--json", str(path)]).stdout)["missions"]
    assert record["expected_time_is_lower_bound"]
    path.write_text(head + "expect: {max_time: 2 s}\n")
    told = CliRunner().invoke(app, ["validate", str(path)]).stdout
    assert "   expected to fail: the mission takes 4.5 s, expect.max_time is 2 s; computed at 2.00 m/s (" in told


def test_a_file_that_is_wrong_as_a_whole_is_one_problem_at_the_key_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text('{"contacts": [{"source": 1, "dest": 2, "startTime": 0, "endTime": 9}]}')
    path = tmp_path / "m.yaml"
    path.write_text(
        "name: dog\npolicy: p\nwaypoints: [[3, 4]]\n"
        "link: { contact_plan: { file: plan.json, from_node: 1, to_node: 2 } }\n"
    )
    result = CliRunner().invoke(app, ["validate", str(path)])
    (line,) = result.stdout.splitlines()
    assert result.exit_code == 2
    assert line.startswith(f"{path}:4:31: link.contact_plan.file: {tmp_path / 'plan.json'} is JSON")
