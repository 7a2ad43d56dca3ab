"""Rollouts: a policy on many paths in parallel, one robot on each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.evaluation.suite import Hold
from waypointctl.policy.protocol import Policy
from waypointctl.robots.robot import stance_action
from waypointctl.task.batched import BatchedWaypointEnv, Step
from waypointctl.units import NS_PER_S, ns, seconds

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Rollouts:
    """How n trials went, each an array (n,). A trial ends in exactly one of success, fell, timed_out and strayed."""

    success: BoolArray  # all waypoints were reached, and the last one was held if the suite has `hold`
    fell: BoolArray  # it ended in a fall, also in one at the last waypoint
    timed_out: BoolArray  # it ended at the deadline
    strayed: BoolArray  # the last waypoint was reached, but the robot did not stay there
    orbiting: BoolArray  # of the time-outs, the robot circled its waypoint
    stuck: BoolArray  # of the time-outs, the robot had stopped making way
    time_s: FloatArray  # from the start until the last waypoint was reached, or the trial ended before [s]
    path_m: FloatArray  # length of the base's path over the ground in that time [m]
    straight_m: FloatArray  # length of the straight lines from the start through the waypoints [m]
    legs: IntArray  # waypoints of the path
    legs_reached: IntArray  # how many of them were reached
    legs_time_s: FloatArray  # from the start until the last of those [s]
    paths: tuple[FloatArray, ...]  # each the waypoints (m, 2) [m]
    # each the positions of the base, ten times a second, (k, 2) [m]; of the first TRACED trials
    trajectories: tuple[FloatArray, ...]

    @property
    def spl(self) -> float:
        """Success weighted by path length, mean of S L / max(L, P) (Anderson et al. 2018, arXiv:1807.06757)."""
        return float(np.mean(self.success * self.straight_m / np.maximum(self.straight_m, self.path_m)))


def rollout(
    env: BatchedWaypointEnv,
    policy: Policy,
    paths: Sequence[FloatArray],
    ended: Callable[[int], None],
    hold: Hold | None = None,
) -> Rollouts:
    """Run a policy with each robot of `env`, made with autoreset off, on a path of its own until each trial has ended.

    Where the last waypoint has to be held, the standing controller takes over when it is reached, as the executive on
    board does. Robots whose trial has ended are not simulated further.

    Args:
        env: as many robots as paths.
        policy: drives the robots; its actions are taken as they are.
        paths: each the waypoints (m, 2) [m], without the start.
        ended: called with the number of trials that have ended so far, whenever it grows.
        hold: how the last waypoint has to be held; None: reaching it is enough.
    """
    for robot, path in enumerate(paths):
        env.begin([robot], path)
    policy.reset(np.ones(env.num_robots, bool))
    trials = _Trials(env, paths, hold)
    observation = env.observe()
    while trials.going.any():
        step = env.step(trials.actions(policy, observation))
        observation = step.observation
        if trials.take(step):
            env.batch.stepped = trials.going  # robots whose trial has ended are not simulated further
            ended(int((~trials.going).sum()))
    env.batch.stepped = None
    return trials.rollouts()


class _Trials:
    """The trials under way: which robots move or hold, and how the other trials ended."""

    def __init__(self, env: BatchedWaypointEnv, paths: Sequence[FloatArray], hold: Hold | None) -> None:
        n = env.num_robots
        self._env, self._paths, self._hold = env, tuple(paths), hold
        self._start: FloatArray = env.batch.qpos[:, :2].copy()
        self._position, self._end = self._start, self._start.copy()
        self._track = Track(self._position, env.robot.control_period_ns)
        self._moving: BoolArray = np.ones(n, bool)
        self._holding, self._success, self._fell, self._timed_out = (np.zeros(n, bool) for _ in range(4))
        self._strayed, self._orbiting, self._stuck = (np.zeros(n, bool) for _ in range(3))
        self._steps, self._legs_reached, self._legs_steps, self._held = (np.zeros(n, np.int64) for _ in range(4))
        self._path_m: FloatArray = np.zeros(n)

    @property
    def going(self) -> BoolArray:
        return self._moving | self._holding

    def actions(self, policy: Policy, observation: FloatArray) -> FloatArray:
        """Return the actions (n, nu) of all robots; a row does not depend on which others still move."""
        env, moving, holding = self._env, self._moving, self._holding
        actions: FloatArray = np.zeros((env.num_robots, env.robot.num_actions))
        if moving.any():
            # A policy with a state has a row of it for each robot, and so acts for all of them.
            actions[moving] = policy.act(observation)[moving] if policy.state() else policy.act(observation[moving])
        if holding.any():
            actions[holding] = stance_action(env.robot, env.batch.qpos[holding], env.batch.qvel[holding])
        return actions

    def take(self, step: Step) -> bool:
        """Take the result of a control step; return whether a trial has ended in it."""
        going = self.going
        before, self._position = self._position, self._env.batch.qpos[:, :2].copy()
        self._steps += self._moving
        self._path_m += self._moving * np.linalg.norm(self._position - before, axis=1)
        self._track.add(self._position)
        self._fell |= going & step.terminated
        reached = self._moving & step.reached & ~step.terminated
        self._legs_reached += reached
        self._legs_steps[reached] = self._steps[reached]
        self._hold_on(self._holding & ~step.terminated)
        self._time_out(self._moving & step.truncated & ~step.success)
        self._arrive(self._moving & step.success)
        done = going & (self._success | self._fell | self._timed_out | self._strayed)
        self._moving &= ~done
        self._holding &= ~done
        self._end[done] = self._position[done]
        return bool(done.any())

    def rollouts(self) -> Rollouts:
        period_s = seconds(self._env.robot.control_period_ns)
        ways = map(np.vstack, zip(self._start, self._paths, strict=True))
        traced = zip(range(TRACED), self._steps + self._held, self._end, strict=False)
        return Rollouts(
            success=self._success,
            fell=self._fell,
            timed_out=self._timed_out,
            strayed=self._strayed,
            orbiting=self._orbiting,
            stuck=self._stuck,
            time_s=self._steps.astype(np.float64) * period_s,
            path_m=self._path_m,
            straight_m=np.array([np.linalg.norm(np.diff(way, axis=0), axis=1).sum() for way in ways]),
            legs=np.array([len(path) for path in self._paths]),
            legs_reached=self._legs_reached,
            legs_time_s=self._legs_steps.astype(np.float64) * period_s,
            paths=self._paths,
            trajectories=tuple(self._track.trajectory(robot, int(steps), end) for robot, steps, end in traced),
        )

    def _arrive(self, arrived: BoolArray) -> None:
        if self._hold is None:
            self._success |= arrived
            return
        self._moving &= ~arrived
        self._holding |= arrived
        self._strayed |= arrived & self._is_off(self._hold)

    def _hold_on(self, holding: BoolArray) -> None:
        if self._hold is None:
            return
        self._held += holding
        self._strayed |= holding & self._is_off(self._hold)
        held_ns = self._held * self._env.robot.control_period_ns
        self._success |= holding & ~self._strayed & (held_ns >= ns(self._hold.time_s))

    def _is_off(self, hold: Hold) -> BoolArray:
        offset_m = self._position - self._env.progress.goals[:, 0]
        return np.asarray(np.linalg.norm(offset_m, axis=1) > hold.within_m)

    def _time_out(self, timed_out: BoolArray) -> None:
        self._timed_out |= timed_out
        robots = np.flatnonzero(timed_out)
        if len(robots):
            window = self._track.window(robots, self._position[robots])
            self._orbiting[robots] = is_orbiting(window, self._env.progress.goals[robots, 0])
            self._stuck[robots] = is_stuck(window) & ~self._orbiting[robots]


SAMPLES_PER_S: Final = 10
WINDOW_S: Final = 5  # before the time-out: the window that classifies it
NEAR_M: Final = 3.0  # an orbit stays this near the waypoint
STILL_M: Final = 0.5  # a robot that stays this near the middle of its last positions is stuck
TRACED: Final = 1000  # trials whose whole trajectory is kept


class Track:
    """Positions of n robots, ten times a second: the last seconds of each, all of the first ones."""

    def __init__(self, position: FloatArray, control_period_ns: int) -> None:
        """Begin with the robots at position (n, 2) [m]."""
        self._every = max(1, NS_PER_S // (SAMPLES_PER_S * control_period_ns))  # control steps
        self._steps = 0
        self._window: FloatArray = np.repeat(position[np.newaxis], WINDOW_S * SAMPLES_PER_S + 1, axis=0)
        self._sampled = [position[:TRACED].copy()]

    def add(self, position: FloatArray) -> None:
        """Take where the robots are, (n, 2) [m], after a further control step."""
        self._steps += 1
        if self._steps % self._every == 0:
            self._window[self._slot()] = position
            self._sampled.append(position[:TRACED].copy())

    def window(self, robots: NDArray[np.intp], position: FloatArray) -> FloatArray:
        """Return where robots (k,) were in the last seconds and are now, position (k, 2): (samples, k, 2) [m]."""
        newest_last = np.roll(self._window[:, robots], -self._slot() - 1, axis=0)
        return np.concatenate([newest_last, position[np.newaxis]])

    def trajectory(self, robot: int, steps: int, end: FloatArray) -> FloatArray:
        """Return the trajectory (samples, 2) [m] of one of the TRACED robots, after `steps` steps at `end` (2,)."""
        samples = self._sampled[: steps // self._every + 1]
        return np.array([*(sample[robot] for sample in samples), end])

    def _slot(self) -> int:
        return (self._steps // self._every) % len(self._window)


def is_orbiting(window: FloatArray, goals: FloatArray) -> NDArray[np.bool_]:
    """Return which trajectories (samples, k, 2) [m] circle their goals (k, 2): more than once, and near."""
    offset = window - goals
    bearing = np.unwrap(np.arctan2(offset[..., 1], offset[..., 0]), axis=0)
    near = np.linalg.norm(offset, axis=2).max(axis=0) < NEAR_M
    return np.asarray(near & (np.abs(bearing[-1] - bearing[0]) > 2 * np.pi))


def is_stuck(window: FloatArray) -> NDArray[np.bool_]:
    """Return which trajectories (samples, k, 2) [m] stay in one place."""
    return np.asarray(np.linalg.norm(window - window.mean(axis=0), axis=2).max(axis=0) < STILL_M)
