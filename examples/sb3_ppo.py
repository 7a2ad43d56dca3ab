"""Train stable-baselines3's own PPO on the gymnasium environment.

    python examples/sb3_ppo.py [--steps 200000]

`waypointctl train` is much faster: it steps hundreds of robots in one call.
"""

from __future__ import annotations

import argparse

from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import waypointctl


def main(steps: int) -> None:
    """Train, then measure the mean episode reward."""
    config = waypointctl.TaskConfig(observation="egocentric")
    model = PPO("MlpPolicy", waypointctl.WaypointEnv(config), n_steps=min(steps, 2048), seed=0, device="cpu")
    model.learn(steps)
    mean, deviation = evaluate_policy(model, Monitor(waypointctl.WaypointEnv(config)), n_eval_episodes=3)
    print(f"after {model.num_timesteps} steps: {mean:.1f} +- {deviation:.1f} an episode")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=200_000)
    main(parser.parse_args().steps)
