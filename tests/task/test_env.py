from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import entry_points
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.robots.load import load_robot
from waypointctl.seeding import stream
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig, draw_start
from waypointctl.task.course import Course, Deadline
from waypointctl.task.env import WaypointEnv
from waypointctl.task.observation import LAYOUTS
from waypointctl.task.register import ENV_ID, register

BUSY = TaskConfig(
    course=Course(perimeter="legs", count=3, leg_m=(0.1, 0.9)),
    acceptance=Acceptance(shape="radius", size_m=0.45),
    deadline=Deadline(first_s=0.8, further_s=0.5),
    start=Start(joint_spread_rad=0.3, speed_spread=1.5),
)


@pytest.fixture
def env() -> WaypointEnv:
    return WaypointEnv(BUSY)


@pytest.mark.parametrize("name", LAYOUTS)
def test_gymnasiums_checker_has_no_complaint_and_no_warning(name: str) -> None:
    made = gymnasium.make(ENV_ID, config=TaskConfig(observation=name))
    check_env(made.unwrapped, skip_render_check=True)  # a render mode may warn that there is no display


def test_stable_baselines3s_checker_has_no_complaint_and_no_warning() -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(WaypointEnv())


def test_is_the_batched_env_of_one_robot_exactly(env: WaypointEnv) -> None:
    batched = BatchedWaypointEnv(BUSY, 1, 5, autoreset=False)
    rng = np.random.default_rng(0)
    observation, info = env.reset(seed=5)
    np.testing.assert_array_equal(observation, batched.reset()[0])
    np.testing.assert_array_equal(info["waypoints"], batched.progress.waypoints[0])
    ends = {"success": 0, "fell": 0, "timed_out": 0}
    push = rng.uniform(-1, 1, 8)
    for _ in range(1500):
        action = np.clip(push + 0.5 * rng.uniform(-1, 1, 8), -1, 1).astype(np.float32)
        step = batched.step(action[np.newaxis].astype(np.float64))
        observation, reward, terminated, truncated, info = env.step(action)
        np.testing.assert_array_equal(observation, step.observation[0])
        assert (reward, terminated, truncated) == (step.reward[0], step.terminated[0], step.truncated[0])
        assert [info[f"reward_{name}"] for name in batched.reward.names] == step.terms[0].tolist()
        assert info["waypoint_index"] == batched.progress.index[0]
        assert info["waypoint_reached"] == step.reached[0]
        assert info["success"] == step.success[0]
        if terminated or truncated:
            assert [info[end] for end in ends].count(True) == 1
            ends = {end: count + info[end] for end, count in ends.items()}
            observation, _ = env.reset()
            np.testing.assert_array_equal(observation, batched.reset()[0])
            push = rng.uniform(-1, 1, 8) * rng.choice([0.3, 2.0])
    assert min(ends.values()) >= 2, f"{ends}: not every end was met"


def test_the_observation_stays_within_its_space(env: WaypointEnv) -> None:
    observation, _ = env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(100):
        assert env.observation_space.contains(observation)
        observation = env.step(env.action_space.sample())[0]


def test_the_same_seed_begins_the_same_episodes(env: WaypointEnv) -> None:
    other = WaypointEnv(BUSY)
    for seed in (3, None, None):
        first, second = env.reset(seed=seed), other.reset(seed=seed)
        np.testing.assert_array_equal(first[0], second[0])
        np.testing.assert_array_equal(first[1]["waypoints"], second[1]["waypoints"])
    assert not np.array_equal(env.reset(seed=4)[0], env.reset(seed=3)[0])


def test_without_a_seed_two_envs_begin_differently(env: WaypointEnv) -> None:
    assert not np.array_equal(env.reset()[0], WaypointEnv(BUSY).reset()[0])


def test_options_say_where_to_begin_and_where_to_go_in_this_episode_alone(env: WaypointEnv) -> None:
    course = [[1, 2], [3, 4], [5, 6], [7, 8], [9, 10]]
    options = {"waypoints": course, "position_m": [4.0, -2.0], "heading_rad": 1.25}
    _, info = env.reset(seed=9, options=options)
    np.testing.assert_array_equal(info["waypoints"], course)
    start = Start(position_m=(4.0, -2.0), heading_deg=math.degrees(1.25), joint_spread_rad=0.3, speed_spread=1.5)
    expected, _ = draw_start(start, load_robot("ant"), stream(9, "start", 0))
    np.testing.assert_array_equal(env._env.batch.qpos[0], expected)
    _, info = env.reset()
    assert info["waypoints"].shape == (3, 2)
    assert env._env.batch.qpos[0, :2].tolist() == [0.0, 0.0]


def test_a_given_course_is_walked_to_its_end() -> None:
    env = WaypointEnv(TaskConfig(acceptance=Acceptance(shape="box", size_m=3.0)))
    env.reset(seed=0, options={"waypoints": [[0.1 * i, 0.0] for i in range(7)]})
    still = np.zeros(8, np.float32)
    for index in range(1, 7):
        *_, truncated, info = env.step(still)
        assert (info["waypoint_index"], truncated) == (index, False)
    *_, truncated, info = env.step(still)
    assert (info["waypoint_index"], truncated, info["success"]) == (6, True, True)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"waypoint": [[1, 2]]}, "unknown option of reset: 'waypoint'; allowed: waypoints, position_m, heading_"),
        ({"waypoints": [1, 2]}, r"options\['waypoints'\] has the shape \(2,\); expected \(m, 2\)"),
        ({"waypoints": []}, r"options\['waypoints'\] has the shape"),
        ({"waypoints": [[1, 2], [3]]}, r"options\['waypoints'\] must be numbers"),
        ({"waypoints": [["a", "b"]]}, r"options\['waypoints'\] must be numbers"),
        ({"waypoints": [[1, np.nan]]}, r"options\['waypoints'\] is .*; every number must be finite"),
        ({"position_m": [1, 2, 3]}, r"options\['position_m'\] has the shape \(3,\); expected \(2,\)"),
        ({"heading_rad": [1.0]}, r"options\['heading_rad'\] has the shape \(1,\); expected one number"),
        ({"heading_rad": np.inf}, r"options\['heading_rad'\] is inf; every number must be finite"),
    ],
)
def test_options_that_make_no_sense_are_refused(env: WaypointEnv, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        env.reset(options=options)


@pytest.fixture
def unregistered() -> Iterator[None]:
    spec = gymnasium.registry.pop(ENV_ID)
    yield
    gymnasium.registry[ENV_ID] = spec


@pytest.mark.usefixtures("unregistered")
def test_the_entry_point_gives_it_its_name_and_twice_is_once() -> None:
    (plugin,) = entry_points(group="gymnasium.envs", name="waypointctl")
    plugin.load()()
    register()
    made = gymnasium.make(ENV_ID)
    assert isinstance(made.unwrapped, WaypointEnv)
    assert made.reset(seed=1)[0].shape == (31,)


def run(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=False)


def test_gymnasium_alone_makes_it_by_module_and_name() -> None:
    done = run(
        "import gymnasium\n"
        f"env = gymnasium.make('waypointctl.task.register:{ENV_ID}')\n"
        "print(type(env.unwrapped).__name__, env.reset(seed=0)[0].shape)"
    )
    assert done.stdout == "WaypointEnv (31,)\n", done.stderr


@pytest.mark.parametrize("module", ["env", "register"])
def test_without_gymnasium_the_message_says_how_to_get_it(module: str) -> None:
    done = run(f"import sys\nsys.modules['gymnasium'] = None\nimport waypointctl.task.{module}")
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith("ModuleNotFoundError: ")
    assert "needs gymnasium, which is not installed: pip install 'waypointctl[train]'" in last


def test_actions_may_be_of_either_precision(env: WaypointEnv) -> None:
    action: NDArray[Any] = np.full(8, 0.25)
    rewards = []
    for dtype in (np.float32, np.float64):
        env.reset(seed=2)
        rewards.append(env.step(action.astype(dtype))[1])
    assert rewards[0] == rewards[1]


@pytest.mark.parametrize(
    ("action", "problem"),
    [
        ([np.nan] * 8, r"the action must be finite: joint 0 is nan\n  An action is a number from -1 to 1"),
        ([0.0] * 7 + [np.inf], r"must be finite: joint 7 is inf"),
        ([0.0, -np.inf] + [0.0] * 6, r"must be finite: joint 1 is -inf"),
        ([0.0] * 7, r"the action must have the shape \(8,\), not \(7,\)"),
        ([[0.0] * 8], r"must have the shape \(8,\), not \(1, 8\)"),
        (0.0, r"must have the shape \(8,\), not \(\)"),
        ([None] * 8, r"the action must be real numbers"),
        (["0"] * 8, r"the action must be real numbers"),
        ([1j] * 8, r"the action must be real numbers"),
        ([[0.0], [0.0, 1.0]], r"the action must be real numbers"),
    ],
)
def test_an_action_that_is_none_is_refused_and_changes_nothing(env: WaypointEnv, action: Any, problem: str) -> None:
    env.reset(seed=0)
    with pytest.raises(InputError, match=problem):
        env.step(action)
    after = env.step(np.zeros(8, np.float32))[0]
    env.reset(seed=0)
    np.testing.assert_array_equal(env.step(np.zeros(8, np.float32))[0], after)


@pytest.mark.parametrize("action", [np.zeros(8, np.int64), np.zeros(8, bool), np.zeros(8, np.float16), [0] * 8])
def test_an_action_may_be_any_real_numbers(env: WaypointEnv, action: Any) -> None:
    env.reset(seed=0)
    expected = env.step(np.zeros(8, np.float32))[0]
    env.reset(seed=0)
    np.testing.assert_array_equal(env.step(action)[0], expected)


def test_the_last_steps_info_has_success_and_the_reason(env: WaypointEnv) -> None:
    reasons = set()
    rng = np.random.default_rng(1)
    env.reset(seed=5)
    for _ in range(3000):
        *_, terminated, truncated, info = env.step(rng.uniform(-1, 1, 8).astype(np.float32))
        assert ("is_success" in info, "end_reason" in info) == (terminated or truncated,) * 2
        if terminated or truncated:
            assert info["is_success"] == info["success"] == (info["end_reason"] == "success")
            assert (info["end_reason"] == "fall") == info["fell"] == terminated
            assert (info["end_reason"] == "time_out") == info["timed_out"]
            reasons.add(info["end_reason"])
            env.reset()
    assert reasons == {"success", "fall", "time_out"}
