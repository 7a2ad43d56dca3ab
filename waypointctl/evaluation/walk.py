"""Walking one path many times at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.policy.protocol import Policy
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.units import seconds

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Walks:
    """How n trials of one path went, each an array (n,). A trial is a success, a fall or a timeout.

    Attributes:
        success: all waypoints were reached.
        fell: it ended in a fall.
        timed_out: it ended at the deadline.
        time_s: from the start to the end of the trial [s].
        walked_m: length of the torso's path over the ground [m].
        straight_m: length of the straight lines from the start through the waypoints [m].
    """

    success: BoolArray
    fell: BoolArray
    timed_out: BoolArray
    time_s: FloatArray
    walked_m: FloatArray
    straight_m: FloatArray

    @property
    def spl(self) -> float:
        """Success weighted by path length, mean of S L / max(L, P) (Anderson et al. 2018, arXiv:1807.06757)."""
        return float(np.mean(self.success * self.straight_m / np.maximum(self.straight_m, self.walked_m)))


def walk(env: BatchedWaypointEnv, policy: Policy, waypoints: FloatArray, ended: Callable[[int], None]) -> Walks:
    """Walk waypoints (m, 2) [m] with every robot of `env`, made with autoreset off, until each trial has ended.

    Robots whose trial has ended lie with their motors off while the others walk on.

    Args:
        env: as many robots as trials.
        policy: what walks them; its actions are taken as they are.
        waypoints: the path, without the start.
        ended: called with the number of trials that have ended so far, whenever it grows.
    """
    env.begin(range(env.num_robots), waypoints)
    position = env.batch.qpos[:, :2].copy()
    straight_m = _length(position, waypoints)
    success, fell, timed_out = (np.zeros(env.num_robots, bool) for _ in range(3))
    steps = np.zeros(env.num_robots, np.int64)
    walked_m = np.zeros(env.num_robots)
    walking = np.ones(env.num_robots, bool)
    observation = env.observe()
    while walking.any():
        step = env.step(np.where(walking[:, np.newaxis], policy.act(observation), 0.0))
        observation = step.observation
        before, position = position, env.batch.qpos[:, :2].copy()
        walked_m += walking * np.linalg.norm(position - before, axis=1)
        steps += walking

        success |= walking & step.success
        fell |= walking & step.terminated
        timed_out |= walking & step.truncated & ~step.success
        now_ended = walking & (step.terminated | step.truncated)
        walking &= ~now_ended
        if now_ended.any():
            ended(int(env.num_robots - walking.sum()))
    time_s = steps.astype(np.float64) * seconds(env.robot.control_period_ns)
    return Walks(success, fell, timed_out, time_s, walked_m, straight_m)


def _length(start: FloatArray, waypoints: FloatArray) -> FloatArray:
    """Return the length (n,) of the straight lines from start (n, 2) through waypoints (m, 2)."""
    first = np.linalg.norm(waypoints[0] - start, axis=1)
    rest = np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum()
    return np.asarray(first + rest)
