"""Fly one mission with many seeds on all cores, and say how often it succeeds and how long it takes.

python examples/seed_study.py [MISSION.yaml] [--seeds 20]
"""

from __future__ import annotations

import argparse
import statistics
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import waypointctl

MISSIONS = Path(__file__).parents[1] / "missions"


def flown(mission: Path, seed: int) -> waypointctl.FlightResult:
    """Fly the mission with a seed, without a log."""
    return waypointctl.fly(mission, "ant-waypoint", seed=seed)


def main(mission: Path, seeds: int) -> None:
    """Fly all seeds; the results are in the order of the seeds."""
    with ProcessPoolExecutor() as pool:
        results = list(pool.map(partial(flown, mission), range(seeds)))
    times_s = [result.sim_time_ns / 1e9 for result in results if result.outcome == "success"]
    print(f"{len(times_s)} of {seeds} flights succeeded")
    if times_s:
        print(f"median time {statistics.median(times_s):.1f} s, from {min(times_s):.1f} s to {max(times_s):.1f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path, nargs="?", default=MISSIONS / "paper-two-point-moon.yaml")
    parser.add_argument("--seeds", type=int, default=20)
    options = parser.parse_args()
    main(options.mission, options.seeds)
