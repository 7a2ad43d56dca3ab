from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.cli.flying import Program, start
from tests.conftest import observation_of
from tests.robots.folders import CART, CART_XML, write_folder
from waypointctl.cli.app import app
from waypointctl.mission.link import LinkDirection
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.robots.load import load_robot

ROOT = Path(__file__).parents[2]
SHIPPED = sorted(str(path) for path in (ROOT / "missions").glob("*.yaml"))
ANT = observation_of(load_robot("ant"))
OTHER_LAYOUT = ANT.model_copy(update={"names": ("a", *ANT.names[1:])})
BAD = "name: n\npolicy: p\nsead: 3\nwaypoints:\n  - {position: [1 m, 2 m], timeout: 20}\n"


def written(folder: Path, rest: str) -> Path:
    (folder / "p").mkdir()
    shutil.copy(ROOT / "policies" / "ant-waypoint" / "manifest.json", folder / "p")
    path = folder / "m.yaml"
    path.write_text(f"name: dog\npolicy: p\n{rest}")
    return path


@pytest.fixture
def bad(tmp_path: Path) -> Path:
    path = tmp_path / "bad.yaml"
    path.write_text(BAD)
    return path


def test_every_shipped_mission_is_ok() -> None:
    result = CliRunner().invoke(app, ["validate", *SHIPPED])
    assert result.exit_code == 0
    assert [line.split(":")[0] for line in result.stdout.splitlines()] == [f"OK {path}" for path in SHIPPED]


def test_an_ok_line_tells_what_will_be_flown(tmp_path: Path) -> None:
    path = written(tmp_path, "waypoints: [[3, 4], [3, 10]]\nlink: {up: {delay: 2 s, jitter: 10 ms}}\n")
    result = CliRunner().invoke(app, ["validate", str(path)])
    ok = f"OK {path}: dog, 2 waypoints, 11.0 m, link 2 s +- 0.01 s up, 0 s down, autonomy mission\n"
    assert (result.stdout, result.stderr) == (ok, "")


@pytest.mark.parametrize(
    ("link", "text"),
    [
        ("{preset: iss, loss: 1 %}", "link iss: 3.5 s +- 0.5 s with 1 % lost each way"),
        (
            "{up: {rate: 1 kbit/s, duplicate: 2 %}, down: {loss: {p: 0.1, r: 0.3}, keep_order: false}}",
            "link 0 s with 2 % duplicated and 1 kbit/s up, 0 s with 25 % lost in bursts and reordering down",
        ),
        (
            "{delay_table: [{at: 0 s, delay: 3 s}, {at: 1 h, delay: 4 s}], windows: [{from: 0 s, to: 1 s}]}",
            "link 3 to 4 s with 1 window each way",
        ),
        (
            "{delay: 1 s, jitter: 2 s, jitter_distribution: normal, "
            "windows: [{from: 0 s, to: 1 s}], windows_period: 1 h}",
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
    path.write_text(f"name: dog\npolicy: ant-waypoint\nwaypoints: [[3, 4]]\nlink: {link}\n")
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


def test_a_policy_that_is_not_there_is_a_problem(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: nowhere\nwaypoints: [[3, 4]]\n")
    result = CliRunner().invoke(app, ["validate", "--json", str(path)])
    assert result.exit_code == 2
    (problem,) = json.loads(result.stdout)["missions"][0]["problems"]
    assert [problem[key] for key in ("line", "column", "path")] == [2, 9, "policy"]
    assert (
        CliRunner()
        .invoke(app, ["validate", str(path)])
        .stdout.startswith(f"{path}:2:9: policy: 'nowhere': folder not found")
    )
    assert CliRunner().invoke(app, ["validate", str(path), "--policy", "ant-waypoint"]).exit_code == 0


def test_a_robot_that_is_not_there_is_a_problem(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: ant-waypoint\nwaypoints: [[3, 4]]\nrobot: ./dog\n")
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert result.exit_code == 2
    assert result.stdout.startswith(f"{path}:4:8: robot: './dog': folder not found;")


@pytest.mark.parametrize(
    ("mjcf", "policy", "place"),
    [
        ("<mujoco/>", {}, "4:8: robot: "),
        (CART_XML, {}, "2:9: policy: policy 'tiny': made for the robot 'ant', not 'cart'"),
        (CART_XML, {"robot": "cart", "control_period_ns": 10_000_000}, "2:9: policy: "),
    ],
)
def test_a_robot_that_is_wrong_or_not_the_policys_is_a_problem(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy], mjcf: str, policy: dict[str, object], place: str
) -> None:
    make_policy(tmp_path / "tiny", **policy)
    write_folder(tmp_path / "cart", CART | {"cart.xml": mjcf.encode()})
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: ./tiny\nwaypoints: [[3, 4]]\nrobot: ./cart\n")
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert (result.exit_code, result.stdout[: len(f"{path}:{place}")]) == (2, f"{path}:{place}")


@pytest.mark.parametrize(
    ("policy", "problem"),
    [
        ({"robot": "cart"}, "made for the robot 'cart', not 'ant'"),
        ({"control_period_ns": 10_000_000}, "made for a control period of 10 ms, not 20 ms"),
        ({"observation": OTHER_LAYOUT}, "made for another observation layout 'egocentric': number 0 is 'a'"),
    ],
)
def test_a_policy_that_is_not_the_shipped_robots_is_a_problem(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy], policy: dict[str, object], problem: str
) -> None:
    make_policy(tmp_path / "tiny", **policy)
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: ./tiny\nwaypoints: [[3, 4]]\n")
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert (result.exit_code, f"{path}:2:9: policy: policy 'tiny': {problem}" in result.stdout) == (2, True)


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
    assert lines[3:] == [f"{missing}: there is no such file"]


def test_what_may_go_wrong_is_a_warning_with_its_place(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "expect: {max_time: 2 s}\nwaypoints:\n  - [3, 4]\n  - {position: [3 m, 40 m], timeout: 9 s}\n"
        "link:\n  rate: 1 kbit/s\n",
    )
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert result.exit_code == 0
    places = [line.split(": ")[1:3] for line in result.stderr.splitlines()]
    expected = [("3:10", "expect.max_time"), ("6:29", "waypoints[1].timeout"), ("8:3", "link.rate")]
    assert places == [[f"{path}:{place}", key] for place, key in expected]
    assert CliRunner().invoke(app, ["validate", "--strict", str(path)]).exit_code == 1
    (record,) = json.loads(CliRunner().invoke(app, ["validate", "--json", str(path)]).stdout)["missions"]
    assert [warning["kind"] for warning in record["warnings"]] == ["max_time", "timeout", "rate"]
    assert record["warnings"][0]["place"] == f"{path}:3:10"


def test_a_mission_that_cannot_succeed_fails(tmp_path: Path) -> None:
    path = written(tmp_path, "waypoints: [[3, 4]]\nlink: {loss: 1}\n")
    result = CliRunner().invoke(app, ["validate", str(path), SHIPPED[0]])
    assert result.exit_code == 1
    assert [line.split()[0] for line in result.stdout.splitlines()] == ["FAILS", "OK"]
    report = json.loads(CliRunner().invoke(app, ["validate", "--json", str(path)]).stdout)
    assert (report["ok"], report["missions"][0]["fails"]) == (False, True)


def test_strict_exits_with_0_without_warnings(tmp_path: Path) -> None:
    path = written(tmp_path, "waypoints: [[3, 4]]\n")
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
    path = written(tmp_path, "waypoints: [[3, 4]]\nlink: {delay: 2 s}\n")
    result = CliRunner().invoke(app, ["validate", "--json", str(path)])
    assert result.exit_code == 0
    way = LinkDirection(delay_s=2.0).model_dump(mode="json")
    assert {"delay_s": 2.0, "jitter_s": 0.0, "loss": 0.0, "rate_bps": None}.items() <= way.items()
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
                "fails": False,
                "warnings": [],
                "rehearsals": [],
            }
        ],
    }


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"a: [", b"- 1", b"[" * 5000, b"a: &x [*x]"])
def test_no_content_leads_to_a_traceback(tmp_path: Path, program: Program, content: bytes) -> None:
    path = tmp_path / "m.yaml"
    path.write_bytes(content)
    code, out, err = program("validate", str(path))
    assert (code, err) == (2, "")
    assert out.startswith(f"{path}:1:")


def test_another_policy_that_is_not_there_is_refused(tmp_path: Path, program: Program) -> None:
    code, _, err = program("validate", SHIPPED[0], "--policy", str(tmp_path / "gone"))
    assert code == 2
    assert "gone: folder not found\n" in err


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


def test_rehearsals_are_told_and_counted(yard: Path, program: Program) -> None:
    code, out, _ = program("validate", "easy.yaml", "--rehearse", "2")
    assert code == 0
    assert re.search(r"mission +2 of 2 flights succeeded \(95 % interval 34% to 100%\); median time 2\.\d s", out)
    code, out, _ = program("validate", "far.yaml", "--rehearse", "2", "--json")
    assert code == 1
    (record,) = json.loads(out)["missions"]
    assert (record["ok"], record["fails"]) == (False, True)
    (rehearsal,) = record["rehearsals"]
    assert (rehearsal["flights"], rehearsal["successes"], rehearsal["time_s"]["median"]) == (2, 0, None)
    assert rehearsal["failures"] == [{"cause": "timeout", "waypoint": "away", "flights": 2, "first_seed": 0}]


def test_strict_exits_with_1_if_a_rehearsal_fails(yard: Path, program: Program) -> None:
    lossy = "link: {up: {loss: 50 %}}\ncommands: {retries: 0}\nseed: 3\n"
    (yard / "lossy.yaml").write_text(
        f"name: lossy\npolicy: still\nwaypoints: [[0, 0]]\ndefaults: {{tolerance: 1 m}}\n{lossy}"
    )
    code, out, _ = program("validate", "lossy.yaml", "--rehearse", "6", "--json")
    assert 0 < json.loads(out)["missions"][0]["rehearsals"][0]["successes"] < 6
    assert code == 0
    assert program("validate", "lossy.yaml", "--rehearse", "6", "--strict")[0] == 1


def test_other_autonomies_are_rehearsed_beside_the_missions_own(yard: Path, program: Program) -> None:
    code, out, _ = program("validate", "easy.yaml", "--rehearse", "1", "--autonomy", "waypoint", "--json")
    rehearsals = json.loads(out)["missions"][0]["rehearsals"]
    assert (code, [each["autonomy"] for each in rehearsals]) == (0, ["mission", "waypoint"])
    assert program("validate", "easy.yaml", "--rehearse", "1", "--autonomy", "nobody")[0] == 2
    assert program("validate", "easy.yaml", "--autonomy", "all")[0] == 2


def test_a_rehearsal_that_is_interrupted_exits_with_130(yard: Path) -> None:
    running = start(yard, "validate", "long.yaml", "--rehearse", "50", "--jobs", "1", stderr=subprocess.PIPE)
    assert running.stderr is not None
    assert b"of 50 flights" in running.stderr.readline()
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert b"Traceback" not in err


def test_a_dry_run_flies_and_leaves_no_log(yard: Path, program: Program) -> None:
    code, out, _ = program("run", "--dry-run", "easy.yaml", "far.yaml", "--json")
    outcomes = [each["rehearsals"][0]["each"][0]["outcome"] for each in json.loads(out)["missions"]]
    assert (code, outcomes) == (1, ["success", "failure"])
    assert program("run", "--dry-run", "easy.yaml")[0] == 0
    assert not (yard / "logs").exists()


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("name: a\nphases: [{steps: 640}]\n", "this looks like a training recipe; use `waypointctl train {path}`"),
        ("name: a\ncourses: [{name: b}]\n", "this looks like a suite; use `waypointctl eval --suite {path} POLICY`"),
        ("name: a\ntrials: 3\ncases: []\n", "this looks like a suite; use `waypointctl eval --suite {path} POLICY`"),
    ],
)
def test_a_recipe_and_a_suite_get_one_hint(tmp_path: Path, text: str, hint: str) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(text)
    result = CliRunner().invoke(app, ["validate", str(path)])
    assert result.exit_code == 2
    assert result.stdout == f"{path}: {hint.format(path=path)}\n"


def test_a_file_is_not_a_policys_or_a_robots_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    path = tmp_path / "m.yaml"
    path.write_text("name: dog\npolicy: ./file\nrobot: ./file\nwaypoints: [[3, 4]]\n")
    out = CliRunner().invoke(app, ["validate", str(path)]).stdout
    assert f"{path}:2:9: policy: './file': is a file, not a folder. " in out
    assert f"{path}:3:8: robot: './file': is a file, not a folder; " in out
