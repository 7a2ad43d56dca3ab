"""That a training teaches something: paid for approach alone, the ant approaches."""

from __future__ import annotations

from pathlib import Path

from tests.training.tiny import after, tiny_recipe
from waypointctl.training.status import News, TrainingStatus
from waypointctl.training.train import train

EASY = """\
name: easy
course: {perimeter: legs, count: 2, leg: [2 m, 4 m]}
start: {random_heading: true}
deadline: {first: 2 s, further: 2 s}
network: {hidden: [64, 64], initial_log_std: -1}
ppo: {robots: 64, rollout_steps: 32, minibatch: 512, epochs: 5, gamma: 0.9, reward_scale: 1}
phases:
  - {steps: 65536, learning_rate: [1.0e-3, 1.0e-3], reward: {alive: 0, power: 0, torque: 0, joint_limits: 0}}
"""


def test_the_reward_which_is_the_speed_of_approach_rises(tmp_path: Path) -> None:
    rewards: list[float] = []

    def watch(news: News) -> None:
        if isinstance(news, TrainingStatus):
            rewards.append(news.mean_reward)

    run = tmp_path / "run"
    train(tiny_recipe(tmp_path, EASY), run, run=run, threads=1, watch=watch, interrupted=after(32))
    assert len(rewards) == 32
    assert abs(rewards[0]) < 0.05
    assert rewards[-1] > 0.1  # [m/s] over the last 20 rollouts; seeds 0 to 2 give 0.14 to 0.16
