"""Each example runs, made small, and prints what it is for."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
SHORT = """
name: short
policy: ant-waypoint
waypoints: [{position: [1 m, 0 m]}]
link: {delay: 100 ms}
"""
PRINTED = {
    "fly_and_read_log.py MISSION": r"success: .*\nverified: EXACT\n.*mission short started\n(.*\n)*1 waypoints reached",
    "own_suite.py --trials 2": r"zigzag: \d of 2 succeeded.*\nshort legs: \d of 2 succeeded",
    "own_reward_term.py --steps 64": r"foot_clearance +0\.\d+ in a control step",
    "own_observation_group.py": r"\d gait periods begun\nwith the group: EQUIVALENT\nwithout it: UNVERIFIABLE",
    "sb3_ppo.py --steps 128": r"after 128 steps: ",
    "custom_policy.py": r"failure: .*\nEQUIVALENT: .*\nnot compared: .*__main__\.Wriggle is not in the log",
    "seed_study.py MISSION --seeds 2": r"2 of 2 flights succeeded\nmedian time ",
    "log_to_pandas.py": r"\d+ states, \d+ telemetry frames\ncount ",
}


# These run in the process of the tests, which has loaded the modules; the others define plugins, classes or workers.
IN_PROCESS = ("fly_and_read_log.py", "own_suite.py", "sb3_ppo.py", "log_to_pandas.py")


def test_every_example_is_run() -> None:
    assert {command.split()[0] for command in PRINTED} == {path.name for path in EXAMPLES.glob("*.py")}


@pytest.mark.parametrize("command", PRINTED)
def test_an_example(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    if command.startswith("log_to_pandas"):
        pytest.importorskip("pandas")
    (tmp_path / "short.yaml").write_text(SHORT)
    script, *arguments = command.replace("MISSION", "short.yaml").split()
    if script in IN_PROCESS:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", [script, *arguments])
        runpy.run_path(str(EXAMPLES / script), run_name="__main__")
        out = capfd.readouterr().out
    else:
        program = [sys.executable, str(EXAMPLES / script), *arguments]
        environment = os.environ | {"PYTHONPATH": str(ROOT)}
        out = subprocess.run(
            program, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True, check=True
        ).stdout
    assert re.search(PRINTED[command], out), out
    assert [path.name for path in tmp_path.iterdir()] == ["short.yaml"]
