"""That a training teaches something: rewarded for approach alone, the ant approaches."""

from __future__ import annotations

from pathlib import Path

from tests.training.tiny import new_state, tiny_recipe

EASY = """\
name: easy
course: {perimeter: legs, count: 2, leg: [2 m, 4 m]}
start: {random_heading: true}
deadline: {first: 0.32 s, further: 0.32 s}
network: {hidden: [32, 32]}
algorithm:
  name: ppo
  robots: 128
  rollout_steps: 16
  minibatch: 512
  epochs: 10
  gamma: 0.9
  reward_scale: 1
  initial_log_std: -1
  learning_rate: 3.0e-3
phases: [{steps: 65536, reward: {alive: 0, power: 0, torque: 0, joint_limits: 0}}]
"""


def test_the_reward_which_is_the_speed_of_approach_rises(tmp_path: Path) -> None:
    state = new_state(tiny_recipe(tmp_path, EASY))
    rewards = []
    for _ in range(6):
        rollout = state.learner.collect()  # an episode of each robot
        rewards.append(rollout.reward / rollout.steps)
        state.learner.update()
    assert abs(rewards[0]) < 0.05
    assert rewards[5] > 0.25  # [m/s]; seeds 0 to 3 come to 0.37 to 0.42
