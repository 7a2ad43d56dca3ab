from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.policy.recurrent import Recurrent
from waypointctl.errors import InputError, PolicyError
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.result import read_evaluation
from waypointctl.evaluation.rollout import Rollouts
from waypointctl.evaluation.saved import write_evaluations
from waypointctl.evaluation.suite import Case, RandomPaths, Suite
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.task.course import Deadline

Make = Callable[..., LoadedPolicy]

NEAR = Case(name="near", waypoints=((0.2, 0.0), (0.3, 0.1)), paper=0.4)
FAR = Case(name="far", waypoints=((50.0, 0.0),))
WIDE = Acceptance(shape="box", size_m=2.0)
SHORT = Deadline(first_s=0.5, further_s=0.1)
SUITE = Suite(name="easy", acceptance=WIDE, deadline=SHORT, cases=(NEAR, FAR))
TIGHT = Suite(
    name="tight",
    acceptance=Acceptance(shape="radius", size_m=0.1),
    deadline=Deadline(first_s=1.0, further_s=0.5),
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


@pytest.mark.parametrize(("trials", "seed"), [(0, 0), (1, -1)])
def test_numbers_that_are_none_are_refused(tmp_path: Path, make_policy: Make, trials: int, seed: int) -> None:
    with pytest.raises(InputError, match="is a whole number from"):
        evaluate(make_policy(tmp_path / "still"), SUITE, trials, seed)


def test_it_says_what_was_tested_and_how(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "still", gain=0.0)
    found = json.loads(evaluate(policy, SUITE, trials=2, seed=3).to_json())
    assert list(found) == [
        *("policy", "suite", "seed", "cases", "acceptance", "deadline", "policy_sha256", "versions"),
        *("start", "hold", "suite_acceptance", "observation", "training"),
    ]
    assert (found["policy"], found["suite"], found["seed"]) == ("tiny", "easy", 3)
    assert found["acceptance"] == {"shape": "box", "size_m": 2.0}
    assert found["policy_sha256"] == policy.sha256
    assert set(found["versions"]) == {"waypointctl", "mujoco", "numpy", "onnxruntime"}
    assert list(found["cases"][0]) == [
        *("name", "waypoints", "trials", "successes", "rate", "wilson95"),
        *("falls", "timeouts", "mean_time_s", "spl", "paper"),
        *("orbiting", "stuck", "strayed", "legs", "legs_reached", "mean_leg_time_s", "mean_speed_mps", "course"),
    ]
    assert found["cases"][0]["waypoints"] == [[0.2, 0.0], [0.3, 0.1]]


def test_the_seed_decides_whatever_the_threads(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "wild", gain=3.0)
    first = evaluate(policy, TIGHT, trials=8, seed=5, threads=1)
    assert evaluate(policy, TIGHT, trials=8, seed=5, threads=2).to_json() == first.to_json()
    assert evaluate(policy, TIGHT, trials=8, seed=6, threads=1).cases != first.cases


@pytest.mark.slow
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
        ({"robot": "rover"}, "policy 'tiny': there is no robot 'rover'; there are: ant"),
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
        ("polar", "policy 'tiny': unknown observation layout 'polar'; available: "),
        ("state_goal", "policy 'tiny': made for another observation layout 'state_goal': it has 31 numbers, not 29"),
    ],
)
def test_another_observation_layout_is_refused(tmp_path: Path, make_policy: Make, layout: str, message: str) -> None:
    egocentric = make_policy(tmp_path / "tiny").manifest.observation
    policy = make_policy(tmp_path / "other", observation=egocentric.model_copy(update={"layout": layout}))
    with pytest.raises(PolicyError) as caught:
        evaluate(policy, SUITE, trials=1, seed=0)
    assert str(caught.value).startswith(message)


DRAWN = Suite(
    name="drawn",
    acceptance=Acceptance(shape="radius", size_m=0.2),
    deadline=Deadline(first_s=1.0, further_s=0.5),
    start=Start(random_heading=True),
    courses=(RandomPaths(name="near", perimeter="legs", count=3, leg_m=(0.1, 0.3)),),
)


def walked(policy: LoadedPolicy, suite: Suite, trials: int, seed: int = 5) -> Rollouts:
    seen: list[Rollouts] = []
    evaluate(policy, suite, trials, seed, on_case=lambda case, rollouts: seen.append(rollouts))
    return seen[0]


def test_a_trial_draws_the_same_and_goes_the_same_however_many_there_are(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "wild", gain=3.0)
    few, many = walked(policy, DRAWN, 3), walked(policy, DRAWN, 9)
    for trial in range(3):
        np.testing.assert_array_equal(few.paths[trial], many.paths[trial])
        np.testing.assert_array_equal(few.trajectories[trial], many.trajectories[trial])
    assert len({path.tobytes() for path in many.paths}) == 9
    assert not np.array_equal(walked(policy, DRAWN, 1, seed=6).paths[0], few.paths[0])


def test_another_acceptance_or_policy_draws_the_same_paths(tmp_path: Path, make_policy: Make) -> None:
    first = walked(make_policy(tmp_path / "a", seed=0), DRAWN, 4)
    wider = DRAWN.accepting(Acceptance(shape="box", size_m=1.0))
    other = walked(make_policy(tmp_path / "b", seed=1), wider, 4)
    np.testing.assert_array_equal(first.paths, other.paths)
    assert [way[0].tolist() for way in first.trajectories] == [way[0].tolist() for way in other.trajectories]


def test_drawn_paths_are_as_the_suite_says_and_start_in_any_heading(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "still", gain=0.0)
    paths = np.array(walked(policy, DRAWN, 60).paths)
    legs = np.linalg.norm(np.diff(paths, axis=1, prepend=0.0), axis=2)
    assert paths.shape == (60, 3, 2)
    assert 0.1 <= legs.min() < 0.11
    assert 0.29 < legs.max() <= 0.3
    square = Suite(name="s", courses=(RandomPaths(name="q", count=2, centre_m=(3.0, 0.0), side_m=2.0),))
    paths = np.array(walked(policy, square.model_copy(update={"deadline": SHORT}), 60).paths).reshape(-1, 2)
    assert ((paths > [2.0, -1.0]) & (paths < [4.0, 1.0])).all()
    assert (paths.min(axis=0) < [2.1, -0.9]).all()


def test_the_suite_says_how_many_trials_unless_told(tmp_path: Path, make_policy: Make) -> None:
    policy = make_policy(tmp_path / "still", gain=0.0)
    suite = SUITE.model_copy(update={"trials": 3})
    assert [case.trials for case in evaluate(policy, suite).cases] == [3, 3]
    whole = evaluate(policy, suite, 2)
    assert (whole.trials, whole.successes, whole.rate) == (4, 2, 0.5)
    assert whole.wilson95 == pytest.approx((0.150, 0.850), abs=5e-4)  # Newcombe's method 3 at 2 of 4


def test_every_trial_is_counted_once(tmp_path: Path, make_policy: Make) -> None:
    for seed in range(3):
        (case,) = evaluate(make_policy(tmp_path / f"{seed}", seed=seed, gain=3.0), DRAWN, 20, 1).cases
        assert case.strayed == 0
        assert case.successes + case.falls + case.timeouts == case.trials == 20
        assert case.course == DRAWN.courses[0]
        assert case.waypoints == ()


def test_an_evaluation_of_random_paths_is_read_as_it_was_written(tmp_path: Path, make_policy: Make) -> None:
    evaluation = evaluate(make_policy(tmp_path / "still", gain=0.0), DRAWN, 2, 0)
    write_evaluations([evaluation], tmp_path / "evaluation.json")
    read = read_evaluation(tmp_path / "evaluation.json")
    assert read == evaluation
    assert read.to_json() == evaluation.to_json()


def test_a_policy_that_is_no_bundle_is_evaluated_too() -> None:
    found = evaluate(Recurrent(), SUITE, 2)
    assert (found.policy, found.policy_sha256, found.trials) == ("Recurrent", "", 4)
