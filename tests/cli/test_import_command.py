from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest
from stable_baselines3 import PPO

from tests.cli.flying import Program
from tests.training.sb3_models import normalised_env
from waypointctl.policy.bundle import load_policy

COMMAND = ("policies", "import", "model.zip", "--observation", "egocentric", "--out", "mine")


@pytest.fixture
def shelf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with model.zip and normaliser.pkl."""
    env = normalised_env()
    PPO("MlpPolicy", env, n_steps=64, policy_kwargs={"net_arch": [8, 6]}, device="cpu").save(tmp_path / "model.zip")
    env.save(str(tmp_path / "normaliser.pkl"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_it_says_what_was_made_what_was_checked_and_what_is_trusted(shelf: Path, program: Program) -> None:
    code, out, err = program(*COMMAND, "--vecnormalize", "normaliser.pkl")
    assert (code, err) == (0, "")
    made, normaliser, checked, executed, trusted, try_it = out.splitlines()
    assert made == "mine: PPO, 31 -> 8 -> 6 -> 8, tanh; trained for 0 steps"
    assert normaliser == "  normaliser  normaliser.pkl"
    assert checked.startswith("  checked     gives stable-baselines3's own actions within ")
    assert executed.startswith("  executed    nothing")
    assert trusted == "  trusted     that it was trained on the observations 'egocentric' of the ant, 20 ms a step"
    assert try_it == "  to try it   waypointctl eval mine"


def test_the_policy_is_one_like_any_other(shelf: Path, program: Program) -> None:
    program(*COMMAND)
    (shelf / "easy.yaml").write_text(
        "name: easy\ndeadline: {first_s: 0.2}\ncases: [{name: a, waypoints: [[0.2, 0]]}]\n"
    )
    code, out, _ = program("eval", "mine", "--suite", "easy.yaml", "--trials", "2", "--json")
    assert code == 0
    assert json.loads(out)["cases"][0]["trials"] == 2
    assert program("policies", "show", "mine")[1] == load_policy(shelf / "mine").files["manifest.json"].decode()


def test_json_alone_is_on_stdout(shelf: Path, program: Program) -> None:
    code, out, err = program(*COMMAND, "--json")
    found = json.loads(out)
    assert code == 0
    assert "normaliser  none; a model trained with VecNormalize needs its file: --vecnormalize" in err
    assert found.pop("largest_difference") < 1e-5
    assert found == {
        "policy": "mine",
        "policy_sha256": load_policy(shelf / "mine").sha256,
        "algorithm": "PPO",
        "robot": "ant",
        "observation": "egocentric",
        "hidden_sizes": [8, 6],
        "activation": "tanh",
        "steps": 0,
        "source_sha256": hashlib.sha256((shelf / "model.zip").read_bytes()).hexdigest(),
        "vecnormalize_sha256": None,
    }


def test_an_existing_policy_stays_unless_forced(shelf: Path, program: Program) -> None:
    program(*COMMAND)
    code, out, err = program(*COMMAND)
    assert (code, out) == (2, "")
    assert err == "error: mine: is a policy already\n  Name another folder, or replace it with --force.\n"
    assert program(*COMMAND, "--force")[0] == 0


def test_no_other_command_reads_such_a_file(shelf: Path, program: Program) -> None:
    for command in (("eval", "model.zip"), ("policies", "show", "model.zip")):
        code, out, err = program(*command)
        assert (code, out) == (2, "")
        assert "is a file, not a folder" in err
