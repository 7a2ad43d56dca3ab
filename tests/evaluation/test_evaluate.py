from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.result import read_evaluation, write_evaluation
from waypointctl.evaluation.suite import AcceptanceSpec, Case, DeadlineSpec, Suite
from waypointctl.policy.bundle import LoadedPolicy

Make = Callable[..., LoadedPolicy]

NEAR = Case(name="near", waypoints=((0.2, 0.0), (0.3, 0.1)), paper=0.4)
FAR = Case(name="far", waypoints=((50.0, 0.0),))
WIDE = AcceptanceSpec(shape="box", size_m=2.0)
SHORT = DeadlineSpec(first_s=0.5, further_s=0.1)
SUITE = Suite(name="easy", acceptance=WIDE, deadline=SHORT, cases=(NEAR, FAR))
TIGHT = Suite(
    name="tight",
    acceptance=AcceptanceSpec(shape="radius", size_m=0.1),
    deadline=DeadlineSpec(first_s=1.0, further_s=0.5),
    cases=(Case(name="a", waypoints=((0.12, 0.02),)), Case(name="b", waypoints=((0.1, 0.05), (0.2, 0.1)))),
)


def test_it_counts(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "still", gain=0.0)
    evaluation = evaluate(policy, SUITE, trials=5, seed=3)
    near, far = evaluation.cases
    assert (near.trials, near.successes, near.falls, near.timeouts, near.rate) == (5, 5, 0, 0, 1.0)
    assert near.mean_time_s == pytest.approx(0.04)  # the box is so wide that a step is enough for each waypoint
    assert near.spl == 1.0
    assert near.wilson95[0] == pytest.approx(0.5655, abs=5e-5)
    assert near.wilson95[1] == 1.0
    assert (far.successes, far.timeouts, far.rate, far.mean_time_s, far.spl) == (0, 5, 0.0, None, 0.0)
    assert (near.paper, far.paper) == (0.4, None)


def test_it_says_what_was_tested_and_how(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "still", gain=0.0)
    found = json.loads(evaluate(policy, SUITE, trials=2, seed=3).to_json())
    assert list(found) == [*("policy", "suite", "seed", "cases", "acceptance", "deadline", "policy_sha256", "versions")]
    assert (found["policy"], found["suite"], found["seed"]) == ("tiny", "easy", 3)
    assert found["acceptance"] == {"shape": "box", "size_m": 2.0}
    assert found["policy_sha256"] == policy.sha256
    assert set(found["versions"]) == {"waypointctl", "mujoco", "numpy", "onnxruntime"}
    assert list(found["cases"][0]) == [
        *("name", "waypoints", "trials", "successes", "rate", "wilson95"),
        *("falls", "timeouts", "mean_time_s", "spl", "paper"),
    ]
    assert found["cases"][0]["waypoints"] == [[0.2, 0.0], [0.3, 0.1]]


def test_the_seed_decides_whatever_the_threads(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "wild", gain=3.0)
    first = evaluate(policy, TIGHT, trials=8, seed=5, threads=1)
    assert evaluate(policy, TIGHT, trials=8, seed=5, threads=2).to_json() == first.to_json()
    assert evaluate(policy, TIGHT, trials=8, seed=6, threads=1).cases != first.cases


def test_two_fresh_processes_say_the_same(tmp_path: Path, make_policy: Make) -> None:
    make_policy(tmp_path / "wild", gain=3.0)
    (tmp_path / "tight.yaml").write_text(
        "name: tight\nacceptance: {shape: radius, size_m: 0.1}\ndeadline: {first_s: 1, further_s: 1}\n"
        "cases: [{name: a, waypoints: [[0.12, 0.02]]}]\n"
    )
    program = [sys.executable, "-c", "from waypointctl.cli.main import main; main()"]
    command = [*program, "eval", "wild", "--suite", "tight.yaml", "--trials", "6", "--json"]
    outputs = [subprocess.run(command, cwd=tmp_path, capture_output=True, check=True).stdout for _ in range(2)]
    assert outputs[0] == outputs[1]
    assert json.loads(outputs[0])["cases"][0]["trials"] == 6


def test_a_case_goes_the_same_alone_and_among_others(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "wild", gain=3.0)
    both = evaluate(policy, TIGHT, trials=8, seed=5)
    alone = evaluate(policy, TIGHT.model_copy(update={"cases": TIGHT.cases[1:]}), trials=8, seed=5)
    assert alone.cases[0] == both.cases[1]


def test_progress_is_told_case_by_case(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "still", gain=0.0)
    told: list[tuple[str, int]] = []
    evaluate(policy, SUITE, trials=4, seed=0, progress=lambda case, ended: told.append((case, ended)))
    assert told == [("near", 4), ("far", 4)]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"robot": "rover"}, "policy 'tiny': there is no robot called 'rover'; there are: ant"),
        ({"control_period_ns": 10_000_000}, "policy 'tiny': made for a control period of 10 ms, not 20 ms"),
    ],
)
def test_a_policy_for_something_else_is_refused(
    tmp_path: Path, make_policy: Make, changes: dict[str, object], message: str
) -> None:
    policy = make_policy(tmp_path / "other", **changes)
    with pytest.raises(PolicyError) as caught:
        evaluate(policy, SUITE, trials=1, seed=0)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("layout", "message"),
    [
        ("polar", "policy 'tiny': there is no observation layout called 'polar'; there are: "),
        ("state_goal", "policy 'tiny': made for another observation layout 'state_goal': it has 31 numbers, not 29"),
    ],
)
def test_another_observation_layout_is_refused(tmp_path: Path, make_policy: Make, layout: str, message: str) -> None:
    egocentric = make_policy(tmp_path / "tiny").manifest.observation
    policy = make_policy(tmp_path / "other", observation=egocentric.model_copy(update={"layout": layout}))
    with pytest.raises(PolicyError) as caught:
        evaluate(policy, SUITE, trials=1, seed=0)
    assert str(caught.value).startswith(message)


def test_an_evaluation_is_read_as_it_was_written(tmp_path: Path, make_policy: Make) -> None:
    evaluation = evaluate(make_policy(tmp_path / "still", gain=0.0), SUITE, trials=2, seed=0)
    write_evaluation(evaluation, tmp_path / "evaluation.json")
    assert read_evaluation(tmp_path / "evaluation.json") == evaluation
