"""Add a reward term of your own: a reward for lifting a foot.

    python examples/own_reward_term.py [--steps 100000]

To train with it, put the function into a file, name the file in a recipe (`plugins: [my_terms.py]`), and run
`waypointctl train` with --allow-plugins; without it the file is not executed.
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray

import waypointctl


@waypointctl.reward_term(name="foot_clearance", unit="m")
def foot_clearance(view: waypointctl.SimulationView) -> NDArray[np.float64]:
    """Return the height of the highest foot, (n,) [m], at most 0.2 m."""
    highest: NDArray[np.float64] = view.foot_heights.max(axis=1)
    return np.minimum(highest, 0.2)


def main(steps: int) -> None:
    """Step 16 robots with random actions, and print the mean of each term of the reward."""
    weights = waypointctl.RewardWeights.model_validate({"progress": 1.0, "foot_clearance": 0.5})
    config = waypointctl.TaskConfig(reward=weights, plugins=(foot_clearance,))
    env = waypointctl.BatchedWaypointEnv(config, num_robots=16, seed=0)
    rng, total = np.random.default_rng(0), np.zeros(len(env.reward.names))
    env.reset()
    for _ in range(steps // env.num_robots):
        step = env.step(rng.uniform(-1.0, 1.0, (env.num_robots, env.robot.num_actions)))
        total += step.terms.sum(axis=0)
    for name, mean in zip(env.reward.names, (total / steps).tolist(), strict=True):
        print(f"{name:24} {mean:9.4f} in a control step")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=100_000)
    main(parser.parse_args().steps)
