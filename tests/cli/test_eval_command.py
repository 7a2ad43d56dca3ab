from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.robots.folders import write_folder
from waypointctl.cli.main import main
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.robots.load import load_robot

Make = Callable[..., LoadedPolicy]

SUITE = """\
name: easy
acceptance: {shape: box, size_m: 2}
deadline: {first_s: 0.2, further_s: 0}
cases:
  - {name: "near [m]", waypoints: [[0.2, 0], [0.3, 0.1]], paper: 0.4}
  - {name: far, waypoints: [[50, 0]]}
"""


@pytest.fixture
def workplace(tmp_path: Path, make_policy: Make, monkeypatch: pytest.MonkeyPatch) -> Path:
    make_policy(tmp_path / "still", gain=0.0)
    (tmp_path / "easy.yaml").write_text(SUITE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("COLUMNS", raising=False)
    return tmp_path


def waypointctl(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr(sys, "argv", ["waypointctl", *arguments])
    with pytest.raises(SystemExit) as caught:
        main()
    return int(caught.value.code or 0)


@pytest.fixture
def evaluated(
    workplace: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str, str]]:
    def run(*arguments: str) -> tuple[int, str, str]:
        code = waypointctl(monkeypatch, "eval", *arguments)
        return (code, *capfd.readouterr())

    return run


Evaluated = Callable[..., tuple[int, str, str]]


def test_a_suite_without_a_robot_is_run_with_the_robot_in_the_policys_folder(
    workplace: Path, make_policy: Make, evaluated: Evaluated
) -> None:
    make_policy(workplace / "run", gain=0.0, robot="mule")
    files = dict(load_robot("ant").files)
    files["robot.yaml"] = files["robot.yaml"].replace(b"name: ant", b"name: mule")
    arguments = ("run", "--suite", "easy.yaml", "--trials", "1")
    code, _, err = evaluated(*arguments)
    assert (code, "there is no robot 'mule'" in err) == (2, True)
    write_folder(workplace / "run" / "robot", files)
    assert evaluated(*arguments)[0] == 0


def test_people_get_a_table_on_stdout(evaluated: Evaluated) -> None:
    code, out, err = evaluated("still", "--suite", "easy.yaml", "--trials", "5", "--seed", "0")
    assert (code, err) == (0, "")
    near = next(line for line in out.splitlines() if "near" in line)
    assert " ".join(near.split()) == "near [m] (0.2, 0) (0.3, 0.1) 5/5 100.0% 56.6-100.0 40% 0 0 10/10 0.04 1.000 0.12"
    far = next(line for line in out.splitlines() if "far" in line)
    assert " ".join(far.split()) == "far (50, 0) 0/5 0.0% 0.0-43.4 0 5 0.000"
    assert out.splitlines()[-2] == "5 of 10 trials failed: 0 falls, 5 time-outs (5 stuck)"
    assert "time [s]" in out


def test_json_is_all_there_is_on_stdout(evaluated: Evaluated) -> None:
    code, out, err = evaluated("still", "--suite", "easy.yaml", "--trials", "5", "--seed", "9", "--json")
    found = json.loads(out)
    assert (code, found["seed"], [case["successes"] for case in found["cases"]]) == (0, 9, [5, 0])
    assert "5/5" in err


def test_out_has_the_same_json(evaluated: Evaluated, workplace: Path) -> None:
    _, out, _ = evaluated("still", "--suite", "easy.yaml", "--trials", "2", "--json", "--out", "evaluation.json")
    assert (workplace / "evaluation.json").read_text() == out


@pytest.mark.parametrize(("rate", "code", "complaint"), [("0", 0, ""), ("0.5", 1, "below 50%: far\n")])
def test_a_required_rate_decides_the_exit_code(evaluated: Evaluated, rate: str, code: int, complaint: str) -> None:
    found, _, err = evaluated("still", "--suite", "easy.yaml", "--trials", "2", "--require", rate)
    assert (found, err) == (code, complaint)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nobody",), "error: nobody: folder not found\n"),
        (("still", "--suite", "papers"), "error: papers: there is no such file\n"),
        (("still", "--suite", "easy.yaml", "--out", "no/where.json"), "error: no/where.json: the evaluation cannot be"),
        (
            ("still", "--suite", "easy.yaml", "--out", "still"),
            "error: still: the evaluation cannot be written: this is",
        ),
        (("still", "--trials", "0"), "'--trials'"),
        (("still", "--seed", "-1"), "'--seed'"),
        (("still", "--require", "90"), "'--require'"),
        (("still", "--require", "nan"), "'--require'"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(
    evaluated: Evaluated, arguments: tuple[str, ...], message: str
) -> None:
    code, out, err = evaluated(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert "Traceback" not in err


def test_an_interruption_is_told(evaluated: Evaluated, workplace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("waypointctl.cli.evaluation_run.evaluate", lambda *_, **__: os.kill(os.getpid(), signal.SIGINT))
    code, out, err = evaluated("still", "--suite", "easy.yaml", "--out", "found.json")
    assert (code, out) == (130, "")
    assert err == "interrupted; nothing was written, because the evaluation is not complete\n"
    assert not (workplace / "found.json").exists()


def test_it_loads_neither_torch_nor_the_exporter(workplace: Path) -> None:
    program = (
        "import sys; from waypointctl.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: print(sorted({'torch', 'stable_baselines3', 'onnx', 'safetensors'} & set(sys.modules)))\n"
    )
    command = [sys.executable, "-c", program, "eval", "still", "--suite", "easy.yaml", "--trials", "1", "--json"]
    out = subprocess.run(command, cwd=workplace, capture_output=True, check=True, text=True).stdout
    assert out.splitlines()[-1] == "[]"
