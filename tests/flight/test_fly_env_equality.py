"""Zero delay is no link: the flight is the environment's own rollout, bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from tests.flight.flying import flown, mission_of, only
from tests.sim.bare import BareWorld
from waypointctl.log.messages import Action, Observation, Reward, State
from waypointctl.mission.fields import Acceptance
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.protocol import Policy
from waypointctl.task.config import TaskConfig
from waypointctl.task.course import Deadline
from waypointctl.task.env import WaypointEnv
from waypointctl.task.reward import RewardWeights

SHIPPED = Path(__file__).parents[2] / "policies" / "ant-waypoint"


NEAR = [[0.32, 0.0], [0.0, 0.33], [-0.25, -0.2]]


def held_together(policy: Policy, waypoints: list[list[float]], size_m: float, seed: int) -> tuple[int, int]:
    """Fly without delay and walk the env's rollout beside it; return steps and waypoints, once all has been equal."""
    legs = [{"position_m": place, "tolerance_m": size_m, "timeout_s": 5.0} for place in waypoints]
    result, messages = flown(mission_of(*legs, seed=seed), policy)
    observations, actions, rewards = only(Observation, messages), only(Action, messages), only(Reward, messages)
    states = only(State, messages)

    weights = RewardWeights(**policy.reward_weights)
    task = TaskConfig(
        observation=policy.observation_layout,
        acceptance=Acceptance(shape="box", size_m=size_m),
        deadline=Deadline(first_s=60.0, further_s=60.0),
        reward=weights,
    )
    env = WaypointEnv(task)
    observation, _ = env.reset(seed=seed, options={"waypoints": waypoints})
    world = BareWorld()
    world.place(states[0].qpos, states[0].qvel)
    reached = 0
    for step, action in enumerate(actions):
        np.testing.assert_array_equal(env._env.batch.integration[0], world.integration)
        expect_state(states[step], world)
        np.testing.assert_array_equal(observation, observations[step].values)
        commanded = policy.act(observation[np.newaxis])[0]
        np.testing.assert_array_equal(commanded, action.commanded)
        observation, reward, terminated, truncated, info = env.step(commanded)
        world.step(action.applied)
        assert reward == rewards[step].total
        assert [info[f"reward_{name}"] for name, _ in rewards[step].terms] == [v for _, v in rewards[step].terms]
        assert (terminated or truncated) <= (step == len(actions) - 1), "the env's episode ended before the flight"
        reached += info["waypoint_reached"]
    expect_state(states[-1], world)
    assert reached == result.waypoints_reached
    assert info["success"] == (result.outcome == "success")
    assert info["fell"] == result.reason.startswith("fall")
    return len(actions), reached


def expect_state(state: State, world: BareWorld) -> None:
    np.testing.assert_array_equal(state.qpos, world.data.qpos)
    np.testing.assert_array_equal(state.qvel, world.data.qvel)
    np.testing.assert_array_equal(state.qacc_warmstart, world.data.qacc_warmstart)


def test_a_fidgeting_policys_flight_is_the_envs_rollout(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy]
) -> None:
    steps = reached = 0
    for weights, seed in ((2, 2), (5, 4), (7, 1), (1, 3)):
        policy = make_policy(tmp_path / f"{weights}", seed=weights, gain=3.0)
        walked, there = held_together(policy, NEAR, 0.3, seed)
        steps, reached = steps + walked, reached + there
    assert steps > 100
    assert reached > 2, "the goal never moved: the flights test too little"


def test_the_shipped_policys_flight_is_the_envs_rollout() -> None:
    steps, reached = held_together(load_policy(SHIPPED), [[4.0, 1.0], [6.0, 4.0], [2.0, 5.0]], 0.5, 3)
    assert reached == 3
    assert steps > 250


def test_a_waypoint_around_the_start_is_reached_in_the_same_step() -> None:
    steps, reached = held_together(load_policy(SHIPPED), [[0.1, 0.1], [2.0, 0.0]], 0.5, 3)
    assert reached == 2
    assert steps > 20


class NoisePolicy(Policy):
    """Acts on everything it sees, the noise too."""

    robot = "ant"
    observation_layout = "state_noise"
    reward_weights: Mapping[str, float] = MappingProxyType({"progress": 1.0})

    def __init__(self) -> None:
        self._gains = np.random.default_rng(5).normal(0.0, 0.3, (29, 8))

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.tanh(observation @ self._gains)


def test_a_policy_that_sees_noise_sees_the_envs() -> None:
    steps, _ = held_together(NoisePolicy(), NEAR, 0.3, 2)
    assert steps > 10
