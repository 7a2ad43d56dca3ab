"""`waypointctl study delay`, of a robot that stands where it shall go."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import pytest

from tests.cli.flying import Program, start
from tests.studies.standing import HERE
from tests.test_architecture import HEAVY, TRAINING, loaded_by
from waypointctl.cli.study import rtts_of
from waypointctl.errors import InputError

SMALL = ("study", "delay", "--policy", "still", "--route", "here.yaml", "--jobs", "1")
FEW = (*SMALL, "--autonomy", "waypoint,mission", "--rtt", "2.56,0", "--seeds", "2")


@pytest.fixture
def field(yard: Path) -> Path:
    (yard / "here.yaml").write_bytes(HERE)
    return yard


def test_it_flies_tells_and_leaves_its_files(field: Path, program: Program) -> None:
    code, out, err = program(*FEW)
    assert code == 0
    rows = [" ".join(line.split()) for line in out.splitlines()]
    assert "mission 0.1 2.6" in rows
    assert any(row.startswith("waypoint 2.56 2/2 34.2-100.0 7.7") and row.endswith(" 0 3") for row in rows)
    assert rows[-1] == "runs/study-delay/delay.png: the picture; the tables in tables.md and cells.csv"
    assert "8 of 8 flights" in err
    assert (field / "runs/study-delay/delay.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_command_again_flies_nothing_and_tables_keep_to_the_terminal(
    field: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    for width, flown in ((80, "0 of 8 flights"), (120, "8 of 8 flights")):
        monkeypatch.setenv("COLUMNS", str(width))
        code, out, err = program(*FEW)
        assert (code, err.splitlines()[0]) == (0, flown)
        assert max(len(line) for line in out.splitlines()[:-1]) <= width


def test_json_is_all_that_is_on_stdout(field: Path, program: Program) -> None:
    code, out, err = program(*FEW, "--json", "--think", "1", "--seed", "5", "--out", "mine")
    found = json.loads(out)
    assert code == 0
    assert out == (field / "mine/study.json").read_text()
    assert (found["seeds"], found["think_s"], found["policy"]) == ([5, 6], 1.0, "tiny")
    assert [(cell["autonomy"], cell["rtt_s"]) for cell in found["cells"]] == [
        ("mission", 0.0), ("mission", 2.56), ("waypoint", 0.0), ("waypoint", 2.56),
    ]  # fmt: skip
    thoughts = found["cells"][2]["time_s"]["value"]
    assert 2.0 < thoughts < 2.2, "between three commands there are two thoughts"
    assert "Claims tested" in err


def test_it_is_interrupted_and_goes_on(field: Path, program: Program) -> None:
    running = start(field, *SMALL, "--autonomy", "mission", "--rtt", "10", "--seeds", "20", stderr=subprocess.PIPE)
    assert running.stderr is not None
    while b"2 of 20 flights" not in running.stderr.readline():
        assert running.poll() is None
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert b"interrupted; the finished flights are in runs/study-delay, and the same command continues" in err
    assert b"Traceback" not in err
    kept = len((field / "runs/study-delay/flights.jsonl").read_bytes().splitlines()) - 1
    assert 2 <= kept < 20
    code, _, err_again = program(*SMALL, "--autonomy", "mission", "--rtt", "10", "--seeds", "2")
    assert (code, err_again.splitlines()) == (0, ["2 of 2 flights"]), "those were flown before the interruption"


@pytest.mark.parametrize(
    ("more", "problem"),
    [
        (("--rtt", "0,x"), "--rtt: 'x' is not a number\n  Give seconds"),
        (("--rtt", "-1"), "--rtt: -1 is not within 0 and 86400 s"),
        (("--rtt", "nan"), "--rtt: nan is not within"),
        (("--rtt", "1,1.0"), "has a value twice"),
        (("--autonomy", "steer"), "--autonomy: 'steer' is not an autonomy; choose from mission"),
        (("--route", "nowhere"), "nowhere: there is no such file"),
        (("--route", "easy.yaml,easy.yaml"), "'easy' is the name of more than one"),
        (("--policy", "nobody"), "nobody: folder not found"),
        (("--out", "here.yaml"), "here.yaml"),
    ],
)
def test_wrong_input_is_one_message_and_flies_nothing(
    field: Path, program: Program, more: tuple[str, ...], problem: str
) -> None:
    code, out, err = program(*SMALL, *more)
    assert (code, out) == (2, "")
    assert problem in err
    assert "Traceback" not in err
    assert not (field / "runs").exists()


def test_another_policy_does_not_go_on_with_a_study(field: Path, program: Program, make_policy: object) -> None:
    assert program(*FEW)[0] == 0
    make_policy(field / "still", seed=9, gain=0.0)  # type: ignore[operator]
    code, _, err = program(*FEW)
    assert code == 2
    assert "runs/study-delay/flights.jsonl: was made with another policy\n  Give another --out" in err


def test_round_trips_are_sorted() -> None:
    assert rtts_of("2.56, 0,.4") == (0.0, 0.4, 2.56)
    with pytest.raises(InputError, match="'' is not a number"):
        rtts_of("1,")


def test_help_names_the_options_and_loads_nothing_heavy(field: Path) -> None:
    code, loaded, printed = loaded_by(field, "study", "delay", "--help")
    assert code == 0
    assert "--find-joint-limit" in printed
    assert not loaded & HEAVY


def test_a_study_loads_no_torch(field: Path) -> None:
    code, loaded, _ = loaded_by(field, *SMALL, "--autonomy", "mission", "--rtt", "0", "--seeds", "1")
    assert code == 0
    assert {"mujoco", "onnxruntime", "matplotlib"} <= loaded, "it has really been flown and drawn"
    assert not loaded & TRAINING
