"""The coat against the batched env it is worn by: a twin of the same seed is the oracle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecCheckNan, VecMonitor, VecNormalize, is_vecenv_wrapped

from waypointctl.mission.fields import Acceptance
from waypointctl.task.batched import BatchedWaypointEnv, Step
from waypointctl.task.config import TaskConfig
from waypointctl.task.course import Course, Deadline
from waypointctl.task.reward import RewardWeights
from waypointctl.training.algorithms.vec_env import BatchedVecEnv
from waypointctl.training.learner import Rollout

ROBOTS = 24
STEPS = 60
SCALE = 0.25

# Waypoints near enough to walk over by chance, little time, and a robot that is soon thrown over.
TASK = TaskConfig(
    reward=RewardWeights(fall=50.0),
    course=Course(perimeter="square", count=2, centre_m=(0.0, 0.0), side_m=1.0),
    acceptance=Acceptance(shape="radius", size_m=0.25),
    deadline=Deadline(first_s=0.7, further_s=0.3),
)


def actions(step: int) -> NDArray[np.float32]:
    """Return torques that turn some robots over and shake the others; some lie beyond the limits."""
    rng = np.random.default_rng(step)
    thrown = np.sign(np.random.default_rng(1).normal(size=(ROBOTS // 2, 8)))
    return np.concatenate([thrown, rng.normal(scale=0.7, size=(ROBOTS - ROBOTS // 2, 8))]).astype(np.float32)


@pytest.fixture(scope="module")
def twins() -> tuple[list[Any], list[Step], BatchedVecEnv]:
    coat = BatchedVecEnv(BatchedWaypointEnv(TASK, ROBOTS, seed=5, threads=1), SCALE)
    twin = BatchedWaypointEnv(TASK, ROBOTS, seed=5, threads=1)
    np.testing.assert_array_equal(np.asarray(coat.reset()), twin.reset().astype(np.float32))
    worn = [coat.step(actions(step)) for step in range(STEPS)]
    bare = [twin.step(actions(step).astype(np.float64)) for step in range(STEPS)]
    assert sum(step.success.sum() for step in bare) > 3
    assert sum(step.terminated.sum() for step in bare) > 3
    assert sum((step.truncated & ~step.success).sum() for step in bare) > 3
    return worn, bare, coat


Twins = tuple[list[Any], list[Step], BatchedVecEnv]


def test_observations_and_rewards_are_the_batched_envs(twins: Twins) -> None:
    for (observation, reward, done, _), step in zip(*twins[:2], strict=True):
        assert (observation.dtype, reward.dtype) == (np.float32, np.float32)
        np.testing.assert_array_equal(observation, step.observation.astype(np.float32))
        np.testing.assert_array_equal(reward, (SCALE * step.reward).astype(np.float32))
        np.testing.assert_array_equal(done, step.terminated | step.truncated)


def test_an_ended_episode_shows_its_last_observation_and_why_it_ended(twins: Twins) -> None:
    for (_, _, done, infos), step in zip(*twins[:2], strict=True):
        assert [robot for robot, info in enumerate(infos) if "terminal_observation" in info] == list(step.ended)
        for robot, final in zip(step.ended, step.final_observation, strict=True):
            assert done[robot]
            np.testing.assert_array_equal(infos[robot]["terminal_observation"], final.astype(np.float32))
            assert infos[robot]["is_success"] == step.success[robot]
            assert infos[robot]["TimeLimit.truncated"] == (not step.terminated[robot])


def test_the_tally_adds_up(twins: Twins) -> None:
    _, bare, coat = twins
    successes = sum(int(step.success.sum()) for step in bare)
    falls = sum(int(step.terminated.sum()) for step in bare)
    timeouts = sum(int((step.truncated & ~step.success).sum()) for step in bare)
    tally = coat.drain()
    assert (tally.successes, tally.falls, tally.timeouts) == (successes, falls, timeouts)
    assert tally.episodes == successes + falls + timeouts
    assert tally.waypoints == sum(int(step.reached.sum()) for step in bare)
    assert tally.steps == ROBOTS * STEPS
    assert tally.reward == pytest.approx(sum(step.reward.sum() for step in bare), rel=1e-12)
    assert coat.drain() == Rollout()


def test_stable_baselines3_finds_nothing_wrong() -> None:
    coat = BatchedVecEnv(BatchedWaypointEnv(TASK, ROBOTS, seed=5, threads=1), SCALE)
    env = VecNormalize(VecMonitor(VecCheckNan(coat, raise_exception=True)), norm_reward=False)
    assert is_vecenv_wrapped(env, VecMonitor)
    assert coat.env_is_wrapped(VecMonitor) == [False] * ROBOTS
    assert env.observation_space.contains(np.asarray(env.reset())[0])
    lengths: list[int] = []
    for step in range(STEPS):
        observation, _, done, infos = env.step(actions(step))
        assert env.observation_space.contains(np.asarray(observation)[0])
        lengths += [info["episode"]["l"] for info, ended in zip(infos, done, strict=True) if ended]
    assert lengths
    assert max(lengths) <= 35 + 15  # 0.7 s at 50 Hz, and 0.3 s more for the one waypoint that is not the last


def test_one_robot_of_a_batch_has_no_env_of_its_own() -> None:
    coat = BatchedVecEnv(BatchedWaypointEnv(TASK, 3, seed=5, threads=1), SCALE)
    assert coat.get_attr("num_envs", [0, 2]) == [3, 3]
    assert coat.seed(1) == [None, None, None]
    with pytest.raises(AttributeError, match="share one env"):
        coat.set_attr("env", Rollout(), 0)
    with pytest.raises(AttributeError, match="call observe on"):
        coat.env_method("observe")
