"""Evaluate a policy on a suite of your own: one given path, and random ones.

    python examples/own_suite.py [--trials 20]

The same suite as a YAML file goes into `waypointctl eval POLICY --suite my-suite.yaml`.
"""

from __future__ import annotations

import argparse

import waypointctl

SUITE = waypointctl.Suite.model_validate(
    {
        "name": "zigzag",
        "acceptance": {"shape": "radius", "size_m": 0.5},
        "cases": [{"name": "zigzag", "waypoints": [[2.0, 1.0], [4.0, -1.0], [6.0, 1.0]]}],
        "courses": [{"name": "short legs", "perimeter": "legs", "count": 4, "leg_m": [1.0, 3.0]}],
    }
)


def main(trials: int) -> None:
    """Evaluate the shipped policy, and print each case."""
    evaluation = waypointctl.evaluate("ant-waypoint", SUITE, trials)
    for case in evaluation.cases:
        low, high = case.wilson95
        print(f"{case.name}: {case.successes} of {case.trials} succeeded, 95 % interval {low:.2f} to {high:.2f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=20)
    main(parser.parse_args().trials)
