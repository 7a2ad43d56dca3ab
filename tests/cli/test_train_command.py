from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.training.tiny import RECIPE
from waypointctl.cli.main import main
from waypointctl.evaluation.result import read_evaluation
from waypointctl.evaluation.suite import Suite, load_suite
from waypointctl.policy.bundle import load_policy
from waypointctl.task.course import Deadline
from waypointctl.training import train
from waypointctl.training.checkpoint import save_checkpoint

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Command:
    """Run `waypointctl train` in an empty folder with a tiny recipe, with next to no time for the paper's paths."""

    def hurried(name: str) -> Suite:
        return load_suite(name).model_copy(update={"deadline": Deadline(first_s=0.1, further_s=0)})

    monkeypatch.setattr(train, "load_suite", hurried)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recipe.yaml").write_text(RECIPE)

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["waypointctl", "train", *arguments, "--threads", "1"])
        with pytest.raises(SystemExit) as caught:
            main()
        return (int(caught.value.code or 0), *capfd.readouterr())

    return run


def test_a_training_ends_with_its_table_and_a_policy_in_the_run(command: Command) -> None:
    code, out, err = command("recipe.yaml")
    assert code == 0
    assert "tiny in the suite paper, seed 1" in out
    assert out.count("0/1") == 10
    assert out.splitlines()[-1].startswith("runs/tiny: trained in 0:")
    assert "100.0%  1.0 k of 1.0 k steps" in err
    assert "phase 2/2" in err
    assert "checkpoint runs/tiny/checkpoints/step-0000001024" in err
    assert load_policy(Path("runs/tiny")).manifest.name == "tiny"
    assert "Traceback" not in out + err
    assert "threads    1 for the physics, 1 for the network\n" in err
    assert Path("runs/tiny/curves.png").read_bytes().startswith(b"\x89PNG")
    assert Path("runs/tiny/curves.csv").read_text().startswith("steps,success_mean,")


def test_resuming_a_complete_run_says_so_and_trains_nothing(command: Command) -> None:
    _, out, _ = command("recipe.yaml", "--json")
    before = json.loads(out)
    written = {path: path.stat().st_mtime_ns for path in Path("runs/tiny/checkpoints").iterdir()}
    code, out, err = command("recipe.yaml", "--resume")
    assert code == 0
    assert "resume     the training is complete at step 1024 of 1024; nothing is left to train" in err
    assert out.splitlines()[-1] == "runs/tiny: the training was complete before; nothing was left to train"
    after = json.loads(command("recipe.yaml", "--resume", "--json")[1])
    assert (before["already_complete"], after["already_complete"]) == (False, True)
    assert before["policy_sha256"] == after["policy_sha256"]
    assert before["evaluation"] == after["evaluation"]
    assert {path: path.stat().st_mtime_ns for path in Path("runs/tiny/checkpoints").iterdir()} == written
    Path("runs/tiny/evaluation.json").unlink()  # a training that was ended in its evaluation has it still to do
    again = json.loads(command("recipe.yaml", "--resume", "--json")[1])
    assert (again["already_complete"], again["evaluation"]) == (True, before["evaluation"])


def test_json_is_all_there_is_on_stdout(command: Command) -> None:
    code, out, err = command("recipe.yaml", "--json", "--out", "made", "--steps", "250", "--seed", "12")
    found = json.loads(out)
    assert (code, found["outcome"], found["policy"], found["run"]) == (0, "complete", "made", "runs/tiny")
    assert (found["seed"], found["steps"], found["total_steps"]) == (12, 256, 256)  # rounded up to whole rollouts
    policy = load_policy(Path("made"))
    assert found["policy_sha256"] == policy.sha256
    assert (policy.manifest.training.seed, policy.manifest.training.steps) == (12, 256)
    assert found["evaluation"] == json.loads(read_evaluation(Path("made/evaluation.json")).to_json())
    assert "tiny in the suite paper" in err
    assert found["threads"] == {"physics": 1, "torch": 1}
    assert (found["curves"], found["picture"]) == ("runs/tiny/curves.csv", "runs/tiny/curves.png")


def test_a_run_to_extend_is_named_by_its_folder_or_in_runs_and_a_policy_is_none(command: Command) -> None:
    command("recipe.yaml")
    Path("longer.yaml").write_text(
        RECIPE.replace("name: tiny", "name: longer").replace("checkpoint_steps", "  - {steps: 128}\ncheckpoint_steps")
    )
    for named in ("tiny", "runs/tiny"):
        code, out, err = command("longer.yaml", "--extend", named, "--json")
        assert (code, json.loads(out)["trained_steps"]) == (0, 1152), err
    Path("policy").mkdir()
    for named in ("policy", "ant-waypoint"):
        code, out, err = command("longer.yaml", "--extend", named)
        assert (code, out) == (2, "")
        assert f"error: {named}: is not a run: it has no checkpoints\n  --extend takes the folder of a run" in err


def test_merely_trying_it_never_overwrites_a_policy(command: Command) -> None:
    before = Path("recipe.yaml").read_bytes()
    for _ in range(2):
        assert command("recipe.yaml", "--steps", "128")[0] == 0
    assert sorted(path.name for path in Path("runs").iterdir()) == ["tiny", "tiny-2"]
    assert sorted(path.name for path in Path().iterdir()) == ["recipe.yaml", "runs"]
    assert Path("recipe.yaml").read_bytes() == before


def test_a_run_goes_on_with_the_seed_and_steps_it_began_with(command: Command) -> None:
    command("recipe.yaml", "--steps", "512", "--seed", "5")
    code, out, _ = command("recipe.yaml", "--resume", "--json")
    found = json.loads(out)
    assert (code, found["seed"], found["total_steps"]) == (0, 5, 512)
    for options, problem in (
        (("--seed", "6"), "the run began with seed 5, not 6"),
        (("--steps", "1024"), "the run began with steps [320, 192], not [640, 384]"),
    ):
        code, out, err = command("recipe.yaml", "--resume", *options)
        assert (code, out) == (2, "")
        assert problem in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nothing.yaml",), "error: nothing.yaml: there is no such file\n"),
        (("runs.yaml",), "error: runs.yaml:1:1: required key 'phases' is missing\n"),
        (("recipe.yaml", "--resume"), "error: runs: no run of 'tiny' with a checkpoint to resume from\n"),
        (("recipe.yaml", "--out", "recipe.yaml"), "error: recipe.yaml: the folder cannot be written: this is a file\n"),
        (("recipe.yaml", "--runs", "recipe.yaml"), "error: recipe.yaml: the folder cannot be written: this is a file"),
        (("recipe.yaml", "--steps", "0"), "'--steps'"),
        (("recipe.yaml", "--seed", "-1"), "'--seed'"),
        (("recipe.yaml", "--seed", "4294967296"), "'--seed': 4294967296 is not a whole number from 0 to 4294967295.\n"),
        (("recipe.yaml", "--seed", "abc"), "'--seed': abc is not a whole number from 0 to 4294967295.\n"),
        (("recipe.yaml", "--stop-at", "95"), "'--stop-at': 95 is not a rate from 0.01 to 1: 95 % is 0.95.\n"),
        (("recipe.yaml", "--stop-at", "0.001"), "'--stop-at': 0.001 is not a rate from 0.01 to 1.\n"),
        (("recipe.yaml", "--stop-at", "nan"), "'--stop-at': nan is not a rate from 0.01 to 1.\n"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(command: Command, arguments: tuple[str, ...], message: str) -> None:
    Path("runs.yaml").write_text("name: none\n")
    code, out, err = command(*arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert "Traceback" not in err
    assert not Path("runs").exists()


def test_without_the_packages_it_says_how_to_install_them(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    code, out, err = command("recipe.yaml")
    assert (code, out) == (2, "")
    assert err == (
        "error: training needs packages that are not installed: torch\n"
        '  Install them with the train extra: pip install ".[train]" in the checkout.\n'
    )


def test_a_signal_stops_it_with_a_policy_and_the_commands_to_go_on(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupting(*arguments: Any) -> Path:
        monkeypatch.setattr(train, "save_checkpoint", save_checkpoint)
        os.kill(os.getpid(), signal.SIGTERM)
        return save_checkpoint(*arguments)

    monkeypatch.setattr(train, "save_checkpoint", interrupting)
    code, out, err = command("recipe.yaml", "--steps", "1000000")
    assert code == 130
    assert "Traceback" not in out + err
    first, go_on, try_it, *curves = out.splitlines()
    assert curves in ([], ["runs/tiny/curves.png: the learning curves; as numbers in curves.csv"])
    assert first.startswith("interrupted after ")
    assert go_on == "  to resume:  waypointctl train recipe.yaml --threads 1 --resume"
    newest = max(Path("runs/tiny/checkpoints").iterdir())
    assert try_it == f"  to try it:  waypointctl eval {newest}"
    assert load_policy(newest).manifest.training.steps == int(newest.name.removeprefix("step-"))
    assert not Path("runs/tiny/manifest.json").exists()


def test_help_the_recipes_schema_and_a_refusal_load_no_torch(tmp_path: Path) -> None:
    program = (
        "import sys; from waypointctl.cli.main import main\n"
        "for command in (['train', '--help'], ['schema', 'recipe'], ['train', 'nothing.yaml']):\n"
        "    sys.argv = ['waypointctl', *command]\n"
        "    try: main()\n"
        "    except SystemExit as end: assert end.code == (2 if 'nothing.yaml' in command else 0)\n"
        "assert not {'torch', 'stable_baselines3'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, check=True)
