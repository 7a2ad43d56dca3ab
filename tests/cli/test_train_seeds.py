from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from rich.console import Console

from tests.cli.flying import Program
from tests.training.scores import NEAR
from tests.training.tiny import RECIPE
from waypointctl.cli.train_run import seeds_of
from waypointctl.cli.tui.training_result import seeds_table
from waypointctl.errors import InputError
from waypointctl.evaluation.suite import Suite, load_suite
from waypointctl.policy.bundle import load_policy
from waypointctl.training import train
from waypointctl.training.seeds import SeedResult, SeedsResult, spreads

SHORT = RECIPE.replace("steps: 640", "steps: 128").replace("steps: 384", "steps: 128")
SELECTING = "selection: {suite: near.yaml, trials: 2, seed: 50, every: 128}\n"


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: Program) -> Program:
    """Run waypointctl in a folder with a tiny recipe, with next to no time for the paper's paths."""

    def hurried(name: str) -> Suite:
        suite = load_suite(name)
        return suite.model_copy(
            update={"deadline": suite.deadline.model_copy(update={"first_s": 0.1, "further_s": 0.0})}
        )

    monkeypatch.setattr(train, "load_suite", hurried)
    monkeypatch.chdir(tmp_path)
    Path("near.yaml").write_text(NEAR)
    Path("recipe.yaml").write_text(SHORT + SELECTING)
    return program


def result(seed: int, rate: float, selection_rate: float | None) -> SeedResult:
    return SeedResult(
        seed, f"runs/seed-{seed}", "0" * 64, 16_000_000, 12_000_000, 3767.0, 1000, rate, 0.01, 0.0, 0.98,
        selection_rate, None,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "seeds"), [("3", [7, 8, 9]), ("1", [7]), ("0,1,2", [0, 1, 2]), ("5, 4294967295", [5, 4294967295])]
)
def test_a_number_is_how_many_and_a_list_is_which(text: str, seeds: list[int]) -> None:
    assert seeds_of(text, 7) == seeds


@pytest.mark.parametrize(
    "text", ["", "0", "-1", "1.5", "a", "1,", "1,1", "1,2,4294967296", "1001", "9999999999", "99999999999", "٣"]
)
def test_anything_else_is_refused_with_what_is_allowed(text: str) -> None:
    with pytest.raises(InputError, match=r"--seeds: .*\n  Give how many, as in --seeds 3, or different whole numbers"):
        seeds_of(text, 7)


def test_two_seeds_are_trained_compared_and_drawn_and_a_third_is_added(command: Program) -> None:
    code, out, err = command("train", "recipe.yaml", "--seeds", "2", "--threads", "1")
    assert code == 0
    assert "tiny, seed 7, 1 of 2, in runs/tiny-seeds/seed-7" in err
    assert "selection  0.0% of 2 at 256, the best" in err
    assert [line.split()[0] for line in out.splitlines()[3:5]] == ["7", "8"]
    assert out.splitlines()[-1] == "runs/tiny-seeds/curves.png: the learning curves; as numbers in curves.csv"
    before = load_policy(Path("runs/tiny-seeds/seed-7")).sha256
    code, out, err = command("train", "recipe.yaml", "--seeds", "7,8,3", "--threads", "1", "--resume", "--json")
    found = json.loads(out)
    assert (code, found["outcome"], found["folder"]) == (0, "complete", "runs/tiny-seeds")
    assert [one["seed"] for one in found["seeds"]] == [7, 8, 3]
    assert found["seeds"][0]["policy_sha256"] == before == load_policy(Path("runs/tiny-seeds/seed-7")).sha256
    assert "seed 7" not in err
    assert found["spread"]["steps"] == {"mean": 256.0, "std": 0.0, "lowest": 256, "highest": 256}
    assert Path(found["picture"]).read_bytes().startswith(b"\x89PNG")
    for options, message in (
        (("--steps", "512"), "the group began with steps [128, 128], not [256, 256]"),
        (("--seed", "3"), "--seed and --seeds cannot both be given"),
    ):
        code, out, err = command("train", "recipe.yaml", "--seeds", "2", "--resume", *options)
        assert (code, out) == (2, "")
        assert message in err


def test_a_target_is_told_in_words_and_in_json(command: Program) -> None:
    Path("near.yaml").write_text(NEAR.replace("[[3, 0]]", "[[0.1, 0]]"))  # where the robot stands already
    code, out, _ = command("train", "recipe.yaml", "--stop-at", "0.95", "--threads", "1")
    assert code == 0
    assert "target met after 128 steps in 0:0" in out
    assert ": 100.0% of 2 trials in near, seed 50" in out
    code, out, _ = command("train", "recipe.yaml", "--stop-at", "0.95", "--threads", "1", "--json")
    found = json.loads(out)
    assert (found["outcome"], found["steps"], found["trained_steps"]) == ("complete", 128, 128)
    assert (found["target"]["met"], found["target"]["steps"], found["target"]["stop_at"]) == (True, 128, 0.95)
    assert 0 <= found["target"]["wall_time_s"] <= found["trained_wall_time_s"] + 0.1
    assert found["selection"]["selected"]["success_rate"] == 1.0


def test_a_target_that_is_not_met_is_said(command: Program) -> None:
    code, out, _ = command("train", "recipe.yaml", "--stop-at", "0.5", "--threads", "1")
    assert code == 0
    assert "target of 0.5 not met in 256 steps; the checkpoint at step 256 of 256 was selected: 0.0% of 2 trials" in out


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (SHORT + "warm_start: none\n", (), "error: recipe.yaml:13:13: warm_start: none: folder not found"),
        (
            SHORT + "selection: {suite: none.yaml}\n",
            ("--seeds", "2"),
            "selection.suite: none.yaml: there is no such file",
        ),
        (SHORT.replace("{trials: 1}", "{seed: 1000}"), ("--stop-at", "0.9"), "--stop-at: evaluation.seed is 1000"),
        (SHORT, ("--seeds", "x"), "--seeds: expected a count or a comma-separated list of seeds"),
        (SHORT, ("--seeds", "2", "--resume"), "no group of seeds of 'tiny' to continue"),
        (SHORT, ("--stop-at", "2"), "'--stop-at'"),
        (SHORT, ("--out", "/proc/x"), "error: /proc/x: the folder cannot be written"),
        (SHORT, ("--out", "/proc/x", "--seeds", "2"), "error: /proc/x: the folder cannot be written"),
        (SHORT, ("--runs", "/proc/x"), "error: /proc/x: the folder cannot be written"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_is_written(
    command: Program, text: str, options: tuple[str, ...], message: str
) -> None:
    Path("recipe.yaml").write_text(text)
    code, out, err = command("train", "recipe.yaml", *options)
    assert (code, out) == (2, "")
    assert message in err
    assert "Traceback" not in err
    assert not Path("runs").exists()


@pytest.mark.parametrize("selected", [True, False])
@pytest.mark.parametrize("width", [80, 120])
def test_the_table_fits_and_cuts_no_number(width: int, selected: bool) -> None:
    results = tuple(result(seed, rate, rate if selected else None) for seed, rate in ((0, 0.986), (4294967295, 1.0)))
    screen = io.StringIO()
    Console(file=screen, width=width).print(
        seeds_table("ant", SeedsResult(results, spreads(results)), Path("seeds.json"))
    )
    lines = screen.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    cells = [line.split() for line in lines if line.split()[:1] in (["0"], ["4294967295"], ["mean"], ["std"])]
    assert cells[0][:2] == ["0", "98.6%"]
    assert cells[1][:2] == ["4294967295", "100.0%"]
    assert cells[2][:2] == ["mean", "99.3%"]
    assert cells[3][:2] == ["std", "1.0%"]
    assert ("selection" in screen.getvalue()) is selected
