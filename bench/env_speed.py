"""The batched env with all it does, against the limit: the same physics with no Python between the steps.

Run: python bench/env_speed.py [--robots 256 1024 2048] [--steps 100] [--rounds 7] [--threads 0] [--no-peer] [--json]

Ours observes, pays, follows courses and begins new episodes. The limit is one mujoco.rollout call over the same model,
from the same standing starts, with the same actions and threads. The peer is stable-baselines3's SubprocVecEnv with
eight Gymnasium envs of one robot each. They run in turns, and ratios are taken per turn, so that a noisy machine
disturbs all alike. One step is one robot's control period. The more robots step together, the less it matters that
numpy finds the caches cold each time the physics has been through them.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from time import perf_counter
from typing import Final

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from waypointctl.mission.fields import Start
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig
from waypointctl.task.course import Course

FloatArray = NDArray[np.float64]

TASK: Final = TaskConfig(course=Course(perimeter="legs"), start=Start(random_heading=True))
PEERS: Final = 8  # processes, one robot each
STATE: Final = mujoco.mjtState.mjSTATE_FULLPHYSICS


@dataclass
class Ours:
    """The batched env; it keeps the starts of its last run for the limit to begin at."""

    actions: FloatArray  # (steps, n, nu)
    threads: int

    def __post_init__(self) -> None:
        self.env = BatchedWaypointEnv(TASK, self.actions.shape[1], 0, threads=self.threads)
        self.ended = 0

    def run(self) -> float:
        """Return the time [s] that all steps take."""
        self.env.reset()
        self.qpos, self.qvel = self.env.batch.qpos.copy(), self.env.batch.qvel.copy()
        self.ended = 0
        begin = perf_counter()
        for actions in self.actions:
            self.ended += len(self.env.step(actions).ended)
        return perf_counter() - begin


class Limit:
    """One mujoco.rollout call for all steps, into arrays that are there already."""

    def __init__(self, ours: Ours) -> None:
        """Make everything that need not be timed."""
        self._ours = ours
        self._model = ours.env.robot.model
        self._data = [mujoco.MjData(self._model) for _ in range(ours.threads)]
        substeps = ours.env.robot.substeps
        self._control = np.repeat(ours.actions.transpose(1, 0, 2), substeps, axis=1).copy()
        robots, steps, _ = self._control.shape
        self._start = np.zeros((robots, mujoco.mj_stateSize(self._model, STATE)))
        self._state = np.empty((robots, steps, self._start.shape[1]))
        self._sensors = np.empty((robots, steps, self._model.nsensordata))

    def run(self) -> float:
        """Return the time [s] that all steps take."""
        scratch = mujoco.MjData(self._model)
        for i, start in enumerate(self._start):
            scratch.qpos[:], scratch.qvel[:] = self._ours.qpos[i], self._ours.qvel[i]
            mujoco.mj_getState(self._model, scratch, start, STATE)
        begin = perf_counter()
        rollout.rollout(
            [self._model] * len(self._start),
            self._data,
            self._start,
            self._control,
            nstep=self._control.shape[1],
            state=self._state,
            sensordata=self._sensors,
            skip_checks=True,
            persistent_pool=True,
        )
        return perf_counter() - begin


def peer(steps: int) -> tuple[Callable[[], float], Callable[[], None]]:
    """Return what steps stable-baselines3's SubprocVecEnv, and what closes it."""
    from stable_baselines3.common.vec_env import SubprocVecEnv

    from waypointctl.task.env import WaypointEnv

    env = SubprocVecEnv([lambda: WaypointEnv(TASK) for _ in range(PEERS)], start_method="forkserver")
    env.reset()
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (steps, PEERS, 8)).astype(np.float32)

    def run() -> float:
        begin = perf_counter()
        for each in actions:
            env.step(each)
        return perf_counter() - begin

    return run, env.close


def measure(robots: int, steps: int, rounds: int, threads: int, with_peer: bool) -> dict[str, float]:
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (steps, robots, 8))
    ours = Ours(actions, threads)
    limit = Limit(ours)
    run_peer, close_peer = peer(steps) if with_peer else (lambda: float("nan"), lambda: None)
    times: list[tuple[float, float, float]] = []
    for _ in range(rounds + 1):
        times.append((ours.run(), limit.run(), run_peer()))
    close_peer()
    counted = times[1:]  # the first round warms caches and threads up
    found: dict[str, float] = {
        "robots": robots,
        "threads": threads,
        "episodes_ended_in_a_round": ours.ended,
        "ours_steps_per_s": round(statistics.median(robots * steps / a for a, _, _ in counted)),
        "limit_steps_per_s": round(statistics.median(robots * steps / b for _, b, _ in counted)),
        "ours_to_limit": round(statistics.median(b / a for a, b, _ in counted), 3),
    }
    if with_peer:
        found["peer_steps_per_s"] = round(statistics.median(PEERS * steps / c for _, _, c in counted))
        found["ours_to_peer"] = round(statistics.median(robots * c / (PEERS * a) for a, _, c in counted), 1)
    return found


def print_table(found: dict[str, float]) -> None:
    print(f"{found['robots']} robots, {found['threads']} threads, {found['episodes_ended_in_a_round']} episodes ended")
    print(f"  {'waypointctl, batched env':32} {found['ours_steps_per_s']:>10,} steps/s")
    print(f"  {'mujoco.rollout, open loop':32} {found['limit_steps_per_s']:>10,} steps/s")
    print(f"  {'  ours to the limit':32} {found['ours_to_limit']:>10.1%}")
    if "peer_steps_per_s" in found:
        print(f"  {f'SubprocVecEnv x {PEERS}':32} {found['peer_steps_per_s']:>10,} steps/s")
        print(f"  {'  ours to the peer':32} {found['ours_to_peer']:>10.1f} x")


def main() -> None:
    parser = argparse.ArgumentParser(description="The batched env against mujoco.rollout and SubprocVecEnv.")
    parser.add_argument("--robots", type=int, nargs="+", default=[256, 1024, 2048], help="a measurement for each")
    parser.add_argument("--steps", type=int, default=100, help="control steps a round")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--threads", type=int, default=0, help="0: one a core")
    parser.add_argument("--no-peer", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with_peer = not options.no_peer and find_spec("stable_baselines3") is not None
    threads = options.threads or len(os.sched_getaffinity(0))
    found = [
        measure(robots, options.steps, options.rounds, threads, with_peer and robots == options.robots[-1])
        for robots in options.robots
    ]
    if options.json:
        print(json.dumps(found, indent=2))
    else:
        for each in found:
            print_table(each)


if __name__ == "__main__":
    main()
