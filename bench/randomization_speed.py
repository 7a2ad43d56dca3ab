"""What each way in which robots can differ costs: the batched env with it, against the same env without.

Run: python bench/randomization_speed.py [--robots 256] [--steps 100] [--rounds 11] [--threads 1] [--json]

All envs take the same actions from the same starts, in turns, and ratios are taken per turn. Time is the processor's,
of all threads together, so that a machine with other things to do disturbs little; "twice without" is the env without
randomization a second time and says how much. One step is one robot's control period.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
from dataclasses import replace
from time import process_time
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.mission.fields import Start
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import DomainRandomization, SensorNoise, TaskConfig
from waypointctl.task.course import Course

FloatArray = NDArray[np.float64]

TASK: Final = TaskConfig(course=Course(perimeter="legs"), start=Start(random_heading=True))
NOISE: Final = SensorNoise(
    joint_angle_rad=0.01,
    joint_speed_radps=0.1,
    position_m=0.01,
    velocity_mps=0.05,
    attitude_rad=0.01,
    gyroscope_radps=0.1,
)
# Bounds close to the model's own values: what robots do, and so what the physics costs, stays nearly the same.
WAYS: Final = {
    "without": DomainRandomization(),
    "twice without": DomainRandomization(),
    "latency": DomainRandomization(latency_s=(0.0, 0.04)),
    "mass": DomainRandomization(mass_factor=(0.95, 1.05)),
    "friction": DomainRandomization(friction_factor=(0.95, 1.05)),
    "gravity": DomainRandomization(gravity_mps2=(9.7, 9.9)),
    "sensor noise": DomainRandomization(sensor_noise=NOISE),
    "all": DomainRandomization(
        latency_s=(0.0, 0.04),
        mass_factor=(0.95, 1.05),
        friction_factor=(0.95, 1.05),
        gravity_mps2=(9.7, 9.9),
        sensor_noise=NOISE,
    ),
}


def time_of(env: BatchedWaypointEnv, actions: FloatArray) -> float:
    """Return the processor time [s] that all actions (steps, n, nu) take."""
    env.reset()
    begin = process_time()
    for each in actions:
        env.step(each)
    return process_time() - begin


def measure(robots: int, steps: int, rounds: int, threads: int) -> dict[str, dict[str, float]]:
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (steps, robots, 8))
    envs = {
        name: BatchedWaypointEnv(replace(TASK, domain_randomization=way), robots, 0, threads=threads)
        for name, way in WAYS.items()
    }
    times = [{name: time_of(env, actions) for name, env in envs.items()} for _ in range(rounds + 1)]
    counted = times[1:]  # the first round warms caches and threads up
    return {
        name: {
            "steps_per_s": round(statistics.median(robots * steps / turn[name] for turn in counted)),
            "to_without": round(statistics.median(turn["without"] / turn[name] for turn in counted), 3),
        }
        for name in envs
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="The batched env with robots that differ, against that without.")
    parser.add_argument("--robots", type=int, default=256)
    parser.add_argument("--steps", type=int, default=100, help="control steps a round")
    parser.add_argument("--rounds", type=int, default=11)
    parser.add_argument("--threads", type=int, default=1, help="of the physics; 0: one a core")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    threads = options.threads or len(os.sched_getaffinity(0))
    found = measure(options.robots, options.steps, options.rounds, threads)
    if options.json:
        print(json.dumps({"robots": options.robots, "threads": threads, "ways": found}, indent=2))
        return
    print(f"{options.robots} robots, {threads} threads")
    for name, each in found.items():
        print(f"  {name:16} {each['steps_per_s']:>10,.0f} steps/CPU s {each['to_without']:>8.1%}")


if __name__ == "__main__":
    main()
