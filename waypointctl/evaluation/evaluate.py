"""Testing a policy on a suite of paths."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from typing import TypeAlias

from waypointctl.errors import InputError, PolicyError
from waypointctl.evaluation.paths import Case, RandomPaths
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.rollout import Walks, walk
from waypointctl.evaluation.suite import Suite
from waypointctl.evaluation.summary import summary
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.require import require
from waypointctl.seeding import stream
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig

Progress: TypeAlias = Callable[[str, int], None]  # (the case's name, its trials that have ended)
Watch: TypeAlias = Callable[[Case | RandomPaths, Walks], None]


def evaluate(
    policy: LoadedPolicy,
    suite: Suite,
    trials: int | None = None,
    seed: int = 0,
    threads: int = 0,
    progress: Progress | None = None,
    watch: Watch | None = None,
) -> Evaluation:
    """Walk each path of a suite many times and count.

    Trial i of a case starts in the same posture, and walks the same path where paths are drawn, whatever the policy,
    the acceptance and the other cases are and however many trials there are.

    Args:
        policy: what is tested.
        suite: the paths.
        trials: of each case, > 0; they are walked side by side. None: as many as the suite says.
        seed: of the starts and of random paths, not negative.
        threads: of the physics; 0 is one a core, 8 at most. The result does not depend on it.
        progress: called whenever trials have ended.
        watch: given the trials of each case, for those who want more than the counts.

    Raises:
        PolicyError: it was made for a robot or an observation layout that there is not, or not any more.
    """
    trials = suite.trials if trials is None else trials
    env = _env(policy, suite, trials, seed, threads)
    results = []
    for case in suite.walked:
        name = f"evaluation/{suite.name}/{case.name}"
        env.starts = [stream(seed, name, trial) for trial in range(trials)]
        env.courses = [stream(seed, f"{name}/course", trial) for trial in range(trials)]
        paths = [case.trial_path(seed, f"{name}/path", trial, suite.start.position_m) for trial in range(trials)]
        walks = walk(env, policy, paths, partial(progress, case.name) if progress else _ignore, suite.hold)
        if watch is not None:
            watch(case, walks)
        results.append(summary(case, walks))
    return Evaluation(
        policy=policy.manifest.name,
        suite=suite.name,
        seed=seed,
        cases=tuple(results),
        acceptance=suite.acceptance,
        deadline=suite.deadline,
        policy_sha256=policy.sha256,
        versions={name: version(name) for name in ("waypointctl", "mujoco", "numpy", "onnxruntime")},
        start=suite.start,
        hold=suite.hold,
        observation=policy.observation_layout,
    )


def _env(policy: LoadedPolicy, suite: Suite, trials: int, seed: int, threads: int) -> BatchedWaypointEnv:
    config = TaskConfig(
        robot=suite.robot or policy.robot,
        observation=policy.observation_layout,
        acceptance=suite.acceptance,
        deadline=suite.deadline,
        start=suite.start,
    )
    longest = max(case.longest for case in suite.walked)
    try:
        env = BatchedWaypointEnv(config, trials, seed, threads=threads, max_waypoints=longest, autoreset=False)
    except InputError as error:
        raise PolicyError(error.problem, where=f"policy {policy.manifest.name!r}") from error
    require(
        policy,
        robot=env.robot.name,
        num_joints=env.robot.num_actions,
        components=env.layout.components,
        control_period_ns=env.robot.control_period_ns,
    )
    return env


def _ignore(ended: int) -> None:
    pass
